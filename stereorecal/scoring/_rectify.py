"""Rectified frames: images and the areas that they really cover, under candidate extrinsics."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Extrinsics, register_pytree
from stereorecal.geometry import bilinear_warp, mapped_area, rectifying_maps, rotation_from_euler
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
