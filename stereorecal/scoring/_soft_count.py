"""The differentiable twin of the count."""

from dataclasses import dataclass, field
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, register_pytree
from stereorecal._errors import InputError
from stereorecal.geometry import PixelMap
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._forward_gradient import forward_gradient
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._pure_arguments import checked_extrinsics, pure_matcher
from stereorecal.scoring._rectify import Rectified, rectify_frames

TEMPERATURE = 0.1  # default width of the gates: its gradient is useful up to some pixels of epipolar error
_BORDER = 5.0  # pixels at a temperature of 1


def soft_count(
    data: ScoringData,
    extrinsics: Float[AnyArray, "6"],
    matcher: AbstractMatcher | str,
    temperature: float | Float[AnyArray, ""] = TEMPERATURE,
) -> Float[jax.Array, ""]:
    """The number of valid pixels with smooth gates in place of the hard ones: uniqueness, left-right consistency,
    texture, and the area that the images cover.

    Pure; compiled once for each matcher and shape of the data (image size, frames, lens model, scale). Composes under
    `jit`, `vmap`, `grad`, `jvp` and `jacfwd` with respect to the extrinsics: a derivative computes six forward
    derivatives together, and keeps no tape. Second derivatives mean nothing, since the best disparity is a hard choice.
    As the temperature goes to 0 it becomes the count of images that are not rounded.

    Args:
        data: from `prepare`; constant, cannot be differentiated.
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: a smooth one (SAD), with `num_disparities` (in full-size pixels).
        temperature: width of the gates, dimensionless (`SAD.soft_match`); a border is 5 temperature pixels wide.

    Raises:
        InputError: if the matcher has no differentiable twin or no `num_disparities`, or the temperature is not
            positive.
    """
    matcher = pure_matcher(matcher, data.scale, "sr.soft_count", smooth=True)
    return _soft_count(_Gates(data, checked_temperature(temperature), matcher), checked_extrinsics(extrinsics))


def checked_temperature(temperature: float | Float[AnyArray, ""]) -> float | Float[AnyArray, ""]:
    """The temperature.

    Raises:
        InputError: if its value is known, and not positive.
    """
    if isinstance(temperature, Tracer):
        return temperature
    if not temperature > 0:
        raise InputError(f"a temperature of {temperature} makes no sense; give a positive number, such as 0.1.")
    return np.asarray(temperature, np.float32)


@register_pytree
@dataclass(frozen=True, eq=False)
class _Gates:
    """The arguments of a soft count other than the extrinsics."""

    data: ScoringData
    temperature: float | Float[AnyArray, ""]
    matcher: AbstractMatcher = field(metadata={"static": True})


@jax.jit
@forward_gradient
def _soft_count(gates: _Gates, extrinsics: Float[jax.Array, "6"]) -> Float[jax.Array, ""]:
    return soft_count_scaled(gates.data, extrinsics, gates.matcher, gates.temperature)


def soft_count_scaled(
    data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher, temperature: float | Float[AnyArray, ""]
) -> Float[jax.Array, ""]:
    """`soft_count`, not compiled by itself and without its rule for derivatives, with a matcher whose disparity range
    is at the scale of `data`."""

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
