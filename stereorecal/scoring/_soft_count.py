"""The differentiable twin of the count."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Float

from stereorecal._arrays import Extrinsics
from stereorecal.geometry import PixelMap
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._prepare import Rectified, ScoringData, rectify_frames

_BORDER = 5.0  # pixels for a temperature of 1


def soft_count(
    data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher, temperature: float | Float[jax.Array, ""]
) -> Float[jax.Array, ""]:
    """The number of valid pixels with smooth gates in place of the hard ones: uniqueness, left-right consistency,
    texture, and the area that the images cover. Pure, traceable and differentiable; for `smooth` matchers.

    As the temperature goes to 0 it becomes the count, but for the rounding of the images, which it does not do.

    Args:
        extrinsics: (6,) float32: pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: with its disparity range at the scale of `data`.
        temperature: width of the gates, dimensionless (`SAD.soft_match`); a border is 5 temperature pixels wide.
    """

    def confidence(frame: Rectified) -> jax.Array:
        found = matcher.soft_match(frame.left, frame.right, temperature)
        width = found.values.shape[-1]
        partner = jnp.arange(width) - found.values
        inside = (partner >= 0) & (partner < width)
        area = jnp.take_along_axis(frame.right_area[None], jnp.clip(partner, 0, width - 1), axis=2)
        return jnp.sum(found.confidence * frame.left_area * jnp.where(inside, area, 0.0))

    area = partial(_soft_area, width=_BORDER * temperature)
    return jnp.sum(rectify_frames(data, extrinsics, confidence, area))


def _soft_area(coordinates: PixelMap, size: tuple[int, int], width) -> Float[jax.Array, "h w"]:
    """`mapped_area` with a border that fades out over `width` pixels."""
    x, y = coordinates[0], coordinates[1]
    inside = jnp.minimum(jnp.minimum(x, size[0] - 1 - x), jnp.minimum(y, size[1] - 1 - y))
    nowhere = (x == -1.0) & (y == -1.0)  # where no ray of the lens reaches
    return jnp.where(nowhere, 0.0, jax.nn.sigmoid(inside / width))
