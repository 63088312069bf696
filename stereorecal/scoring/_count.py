"""The paper's score: the number of pixels with a valid disparity."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._match_frame import match_frame
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._pure_arguments import checked_extrinsics, pure_matcher
from stereorecal.scoring._rectify import Rectified, rectify_frames


def count(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher | str) -> Int[jax.Array, ""]:
    """f(I_l, I_r, Υ) of the paper (eq. 2), summed over the frames: the number of pixels with a valid disparity.

    Pure; compiled once for each matcher and shape of the data (image size, frames, lens model, scale). Composes under
    `jit` and `vmap` over the extrinsics; its derivative is 0 almost everywhere, see `soft_count`. On a CPU it is the
    host's count of the same float32 extrinsics, pixel for pixel, in whatever it is composed. `sr.score` and an
    objective's `value` come to these six numbers in float64, and may so differ by up to 2 pixels and one in 100 000.
    A GPU rounds the warp otherwise: of 181 878 pixels up to 18 were seen to differ.

    Args:
        data: what `prepare` made.
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: one in JAX, with `num_disparities` (in full-size pixels); `with_disparity_range` measures it.

    Raises:
        InputError: if the matcher is not one in JAX, or has no `num_disparities`.
    """
    return _count(data, checked_extrinsics(extrinsics), pure_matcher(matcher, data.scale, "sr.count"))


def count_scaled(data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher) -> Int[jax.Array, ""]:
    """`count`, not compiled by itself, with a matcher whose disparity range is at the scale of `data`."""

    def valid_pixels(frame: Rectified) -> jax.Array:
        return jnp.sum(match_frame(matcher, frame).valid, dtype=jnp.int32)

    return jnp.sum(rectify_frames(data, extrinsics, valid_pixels), dtype=jnp.int32)


_count = partial(jax.jit, static_argnames="matcher")(count_scaled)
