"""Rectified frames: images and the areas that they really cover, under candidate extrinsics; and their match: valid are
the pixels that pass `AbstractMatcher.match`, texture and area.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Extrinsics, namespace, register_pytree
from stereorecal._errors import InputError, MatcherError
from stereorecal.geometry import bilinear_warp, mapped_area, rectifying_maps, rotation_from_euler
from stereorecal.matching import AbstractMatcher, Disparity, name_of, origin_of
from stereorecal.scoring._prepare import ScoringData


@register_pytree
@dataclass(frozen=True, eq=False)
class Rectified:
    """One rectified frame.

    Attributes:
        left, right: (h, w) float32.
        left_area, right_area: (h, w) bool, or float32 in [0, 1] where borders are soft.
    """

    left: Float[AnyArray, "h w"]
    right: Float[AnyArray, "h w"]
    left_area: Bool[AnyArray, "h w"] | Float[AnyArray, "h w"]
    right_area: Bool[AnyArray, "h w"] | Float[AnyArray, "h w"]


def rectify_frames(data: ScoringData, extrinsics: Extrinsics, use, area=mapped_area, warp=bilinear_warp, more=()):
    """Apply `use(Rectified, *more)` to every frame, rectified by `extrinsics` (translation in any unit); stack the
    answers.

    The maps are made once and shared by the frames; `area(map, image size)` says what they cover. `more` are arrays
    with a leading frame axis. Pure and traceable.
    """
    # Numbers that a caller's jit closes over would be folded into the formulas, and pixels rounded otherwise; where it
    # closes over the extrinsics, XLA would warp and match while it compiles.
    numbers = (jnp.asarray(extrinsics, jnp.float32), data.left_camera, data.right_camera, data.view)
    extrinsics, left, right, view = jax.lax.optimization_barrier(numbers)
    maps = rectifying_maps(left, right, rotation_from_euler(extrinsics[:3]), extrinsics[3:], view)
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
