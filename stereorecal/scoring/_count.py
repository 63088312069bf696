"""The paper's score, the number of pixels with a valid disparity; its differentiable twin, and derivatives by forward
mode alone, for scores whose reverse pass would keep every matching cost.
"""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics, product
from stereorecal._errors import InputError
from stereorecal.geometry import PixelMap
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._rectify import (
    Rectified,
    checked_extrinsics,
    match_frame,
    pure_matcher,
    rectify_frames,
    rotations_by,
)

TracedScore = Callable[[Any, Any], jax.Array]

_TEMPERATURE = 0.1  # default width of the gates: its gradient is useful up to some pixels of epipolar error
_BORDER = 5.0  # pixels at a temperature of 1


def forward_gradient(score: TracedScore, with_derivatives: TracedScore | None = None) -> TracedScore:
    """The same `score(data, z)`, z (n,), differentiable in every mode with respect to z; data counts as constant.

    A derivative takes n forward derivatives side by side and keeps only the (n,) gradient: no tape, about n + 1 times
    the work of the score, in reverse (`grad`) as in forward mode (`jvp`, `jacfwd`).

    Args:
        with_derivatives: what to differentiate instead, if it should differ from what is evaluated.
    """
    differentiated = with_derivatives or score

    @jax.custom_jvp
    def differentiable(data, z):
        return score(data, z)

    def rule(primals, tangents):
        (data, z), (of_data, direction) = primals, tangents
        if any(not isinstance(leaf, SymbolicZero) for leaf in jax.tree.leaves(of_data)):
            raise InputError(
                "the score has derivatives with respect to its point only; differentiate with respect to the "
                "extrinsics, and close over data, matcher and temperature."
            )

        def along(unit):
            return jax.jvp(lambda point: differentiated(data, point), (z,), (unit,))

        value, gradient = jax.vmap(along, out_axes=(None, 0))(jnp.eye(z.shape[0], dtype=z.dtype))
        if isinstance(direction, SymbolicZero):
            return value, jnp.zeros_like(value)
        return value, product(gradient, direction).astype(value.dtype)

    differentiable.defjvp(rule, symbolic_zeros=True)
    return differentiable


def count(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher | str) -> Int[jax.Array, ""]:
    """f(I_l, I_r, Υ) of the paper (eq. 2), summed over the frames: the number of pixels with a valid disparity.

    Pure; compiled once for each matcher and shape of the data (image size, frames, lens model, scale). Composes under
    `jit` and `vmap` over the extrinsics; its derivative is 0 almost everywhere, see `soft_count`. On a CPU it is the
    host's count of the same float32 extrinsics, pixel for pixel, in whatever it is composed.

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

    return jnp.sum(rectify_frames(data, rotations_by(extrinsics), valid_pixels), dtype=jnp.int32)


_count = partial(jax.jit, static_argnames="matcher")(count_scaled)


def soft_count(
    data: ScoringData,
    extrinsics: Float[AnyArray, "6"],
    matcher: AbstractMatcher | str,
    temperature: float | Float[AnyArray, ""] = _TEMPERATURE,
) -> Float[jax.Array, ""]:
    """The number of valid pixels with smooth gates in place of the hard ones: uniqueness, left-right consistency,
    texture, and the area that the images cover.

    Pure, and compiled, as `count`. Composes under `jit`, `vmap`, `grad`, `jvp` and `jacfwd` with respect to the
    extrinsics: a derivative computes six forward derivatives together, and keeps no tape. Second derivatives mean
    nothing, since the best disparity is a hard choice. As the temperature goes to 0 it becomes the count of images that
    are not rounded.

    Args:
        data, extrinsics: as for `count`; data are constant, and cannot be differentiated.
        matcher: a smooth one (SAD), with `num_disparities` (in full-size pixels).
        temperature: width of the gates, dimensionless (`SAD.soft_match`); a border is 5 temperature pixels wide.

    Raises:
        InputError: if the matcher has no differentiable twin or no `num_disparities`, or the temperature is not
            positive.
    """
    matcher = pure_matcher(matcher, data.scale, "sr.soft_count", smooth=True)
    return _soft_count_by(matcher)((data, _checked_temperature(temperature)), checked_extrinsics(extrinsics))


def _checked_temperature(temperature: float | Float[AnyArray, ""]) -> float | Float[AnyArray, ""]:
    """The temperature; refused if its value is known, and not positive."""
    if isinstance(temperature, Tracer):
        return temperature
    if not temperature > 0:
        raise InputError(f"a temperature of {temperature} makes no sense; give a positive number, such as 0.1.")
    return np.asarray(temperature, np.float32)


@lru_cache
def _soft_count_by(matcher: AbstractMatcher) -> TracedScore:
    """`soft_count_scaled` of (data, temperature), compiled, with its rule for derivatives."""

    def soft(gates: tuple[ScoringData, Any], extrinsics: Float[jax.Array, "6"]) -> Float[jax.Array, ""]:
        data, temperature = gates
        return soft_count_scaled(data, extrinsics, matcher, temperature)

    return jax.jit(forward_gradient(soft))


def soft_count_scaled(
    data: ScoringData,
    extrinsics: Extrinsics,
    matcher: AbstractMatcher,
    temperature: float | Float[AnyArray, ""] = _TEMPERATURE,
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
    return jnp.sum(rectify_frames(data, rotations_by(extrinsics), confidence, area))


def _soft_area(coordinates: PixelMap, size: tuple[int, int], width) -> Float[jax.Array, "h w"]:
    """`mapped_area` with a border that fades out over `width` pixels."""
    x, y = coordinates[0], coordinates[1]
    inside = jnp.minimum(jnp.minimum(x, size[0] - 1 - x), jnp.minimum(y, size[1] - 1 - y))
    nowhere = (x == -1.0) & (y == -1.0)  # where no ray of the lens reaches
    return jnp.where(nowhere, 0.0, jax.nn.sigmoid(inside / width))
