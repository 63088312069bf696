"""The paper's score: the number of pixels with a valid disparity."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._cores import on_all_cores
from stereorecal.scoring._data import Rectified, ScoringData, rectified_frames, rectify_frames
from stereorecal.scoring._match_frames import match_frames
from stereorecal.scoring._validity import match_frame


def count(data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher) -> Int[jax.Array, ""]:
    """f(I_l, I_r, Υ) of the paper (eq. 2), summed over the frames. Pure and traceable; for traceable matchers.

    Args:
        extrinsics: (6,) float32: pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: with its disparity range at the scale of `data`.
    """

    def valid_pixels(frame: Rectified) -> jax.Array:
        return jnp.sum(match_frame(matcher, frame).valid, dtype=jnp.int32)

    return jnp.sum(rectify_frames(data, extrinsics, valid_pixels), dtype=jnp.int32)


def counts(data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher) -> Int[np.ndarray, "n"]:
    """The count of each candidate, (n,) int64 on the host, for any matcher.

    The programs are those of `disparities`, whatever the size of the batch: a count never depends on how a batch was
    split, and there is nothing more to compile.
    """

    def one(extrinsics: np.ndarray) -> int:
        return sum(int(d.valid.sum()) for d in disparities(data, extrinsics, matcher))

    return np.array(on_all_cores(one, list(np.asarray(candidates, np.float32))), np.int64)


def disparities(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> list[Disparity]:
    """The disparity of each frame under one set of extrinsics, NumPy arrays."""
    rectified = rectified_frames(data, jnp.asarray(extrinsics, jnp.float32))
    return match_frames(matcher, jax.tree.map(np.asarray, rectified))
