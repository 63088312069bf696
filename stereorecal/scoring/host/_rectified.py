"""Rectifying one frame, by a program that is kept."""

import jax
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal._compile_cache import cached_program
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._rectify import Rectified, rectify_frames


def rectified_frame(data: ScoringData, extrinsics: Float[AnyArray, "6"]) -> Rectified:
    """The one frame of `data` rectified by `extrinsics`, float32."""
    return Rectified(*rectified(data, extrinsics))


@cached_program
def rectified(data: ScoringData, extrinsics: Extrinsics) -> tuple[jax.Array, ...]:
    """The images and the areas of it, as they lie in a `Rectified`."""
    frames = rectify_frames(data, extrinsics, lambda frame: frame)
    return frames.left[0], frames.right[0], frames.left_area[0], frames.right_area[0]
