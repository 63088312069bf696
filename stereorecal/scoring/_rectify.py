"""Rectified frames: images and the areas that they really cover, under candidate extrinsics; and their match: valid are
the pixels that pass `AbstractMatcher.match`, texture and area. And checks of the arguments of the pure scores.
"""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Extrinsics, namespace, register_pytree
from stereorecal._errors import InputError, MatcherError
from stereorecal.geometry import (
    StereoRig,
    bilinear_warp,
    mapped_area,
    rectifying_maps,
    rectifying_rotations,
    rotation_from_euler,
)
from stereorecal.matching import AbstractMatcher, Disparity, as_matcher, name_of, origin_of
from stereorecal.scoring._prepare import ScoringData


@register_pytree
@dataclass(frozen=True, eq=False)
class Rectified:
    """One rectified frame."""

    left: Float[AnyArray, "h w"]  # float32
    right: Float[AnyArray, "h w"]  # float32
    left_area: Bool[AnyArray, "h w"] | Float[AnyArray, "h w"]  # float32 in [0, 1] where borders are soft
    right_area: Bool[AnyArray, "h w"] | Float[AnyArray, "h w"]  # likewise


Rotations = Float[AnyArray, "2 3 3"]  # the rotations of both cameras into the rectified frame, float32


def rotations_by(extrinsics: Extrinsics) -> Float[jax.Array, "2 3 3"]:
    """The rotations that rectify by extrinsics (translation in any unit).

    Pure and traceable; compiled, it has the same numbers as a part of a program and as one of its own, which all sizes
    of images share.
    """
    extrinsics = jax.lax.optimization_barrier(jnp.asarray(extrinsics, jnp.float32))
    rotations = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])
    return jax.lax.optimization_barrier(jnp.stack(rotations))


def rectify_frames(data: ScoringData, rotations: Rotations, use, area=mapped_area, warp=bilinear_warp, more=()):
    """Apply `use(Rectified, *more)` to every frame, rectified by `rotations`; stack the answers.

    The maps are made once and shared by the frames; `area(map, image size)` says what they cover. `more` are arrays
    with a leading frame axis. Pure and traceable.
    """
    # Numbers that a caller's jit closes over would be folded into the formulas, and pixels rounded otherwise; where it
    # closes over the rotations, XLA would warp and match while it compiles.
    numbers = (rotations, data.left_camera, data.right_camera, data.view)
    rotations, left, right, view = jax.lax.optimization_barrier(numbers)
    maps = rectifying_maps(left, right, rotations, view)
    maps = jax.lax.optimization_barrier(maps)  # computed once, not once for each pixel that a warp reads
    areas = [area(m, c.size) for m, c in zip(maps, (data.left_camera, data.right_camera), strict=True)]

    def frame(inputs):
        *images, others = inputs
        warped = [warp(i, m) for i, m in zip(images, maps, strict=True)]
        return use(Rectified(*jax.lax.optimization_barrier(warped), *areas), *others)

    return jax.lax.map(frame, (data.left, data.right, more))


def match_frame(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    """Match one rectified frame and keep what lies inside the mapped area of both images.

    Valid: found by the matcher's own rules (unique, textured, left-right consistent), `d >= min_disparity`, and the
    pixel and its match both lie inside the mapped area. Traceable if the matcher is.

    Raises:
        MatcherError: if the matcher crashes; the message names it.
    """
    try:
        disparity = matcher.match(frame.left, frame.right)
    except InputError:
        raise
    except Exception as error:
        raise MatcherError(f"matcher {name_of(matcher)} ({origin_of(matcher)}) crashed: {error!r}") from error
    xp = namespace(disparity.values)
    width = disparity.values.shape[1]
    partner = xp.arange(width) - xp.round(disparity.values).astype(xp.int32)
    inside = (partner >= 0) & (partner < width)
    partner_area = xp.take_along_axis(xp.asarray(frame.right_area), xp.clip(partner, 0, width - 1), axis=1)
    return Disparity(disparity.values, disparity.valid & inside & frame.left_area & partner_area)


def checked_extrinsics(extrinsics: Any) -> Float[jax.Array | np.ndarray, "6"]:
    """The extrinsics of one candidate, (6,).

    Raises:
        InputError: if they are a rig, or have another shape.
    """
    if isinstance(extrinsics, StereoRig):
        raise InputError("the extrinsics are a rig; give rig.extrinsics.")
    if not isinstance(extrinsics, jax.Array | np.ndarray):
        extrinsics = np.asarray(extrinsics, float)
    if jnp.shape(extrinsics) != (6,):
        raise InputError(
            f"the extrinsics have shape {jnp.shape(extrinsics)}, not (6,): pitch, yaw, roll [rad], x, y, z [m]; for "
            "many candidates, use jax.vmap over them."
        )
    return extrinsics


def pure_matcher(matcher: AbstractMatcher | str, scale: float, score: str, *, smooth: bool = False) -> AbstractMatcher:
    """The matcher at an image scale, if the pure function called `score` can use it.

    Raises:
        InputError: if it runs on the host, is not smooth where it must be, or its disparity range is not known.
    """
    matcher = as_matcher(matcher)
    name = type(matcher).__name__
    if not (matcher.smooth if smooth else matcher.traceable):
        raise InputError(
            f"{score} needs a matcher in JAX{' with a differentiable twin' if smooth else ''}, and {name} is none; "
            "use sr.SAD(...), or sr.score, which takes every matcher."
        )
    if matcher.num_disparities is None:
        raise InputError(
            f"{score} needs to know the disparity range; give num_disparities, as in sr.{name}(num_disparities=96), or "
            "have it measured: sr.with_disparity_range(matcher, rig, pairs)."
        )
    return matcher.scaled(scale)
