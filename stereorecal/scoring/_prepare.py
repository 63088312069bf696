"""What a score is computed from: images, cameras and view at one image scale, ready for the kernels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal._errors import InputError
from stereorecal._pytree import register_pytree
from stereorecal.geometry import (
    Camera,
    StereoRig,
    View,
    bilinear_warp,
    mapped_area,
    rectifying_maps,
    rotation_from_euler,
)
from stereorecal.recordings import Pair, check_pairs


@register_pytree
@dataclass(frozen=True, eq=False)
class ScoringData:
    """All that stays the same while extrinsics are tried.

    Attributes:
        left, right: (k, h, w) float32, the frames at the chosen scale.
        left_camera, right_camera: the cameras at that scale.
        view: the one View in which every candidate is judged, at that scale.
    """

    left: Float[AnyArray, "k h w"]
    right: Float[AnyArray, "k h w"]
    left_camera: Camera
    right_camera: Camera
    view: View

    @property
    def frames(self) -> list["ScoringData"]:
        """Each frame alone: programs then need not know how many there are."""
        if len(self.left) == 1:
            return [self]
        left, right = np.asarray(self.left), np.asarray(self.right)  # a slice of NumPy's is no program to compile
        return [replace(self, left=left[i : i + 1], right=right[i : i + 1]) for i in range(len(left))]

    @property
    def pixels(self) -> int:
        """Number of pixels of the view, over all frames."""
        return self.left.shape[0] * self.view.size[0] * self.view.size[1]


def prepare(rig: StereoRig, pairs: Sequence[Pair], view: View, scale: float = 1.0) -> ScoringData:
    """Images, cameras and view resampled to `scale` (0 < scale <= 1) and put on JAX's device.

    Raises:
        InputError: if images and calibration do not fit, or the scale leaves no image.
    """
    pairs = check_pairs(rig, list(pairs))
    width, height = rig.left.size
    size = (round(width * scale), round(height * scale)) if 0.0 < scale <= 1.0 else (0, 0)
    if min(size) < 16:
        raise InputError(f"scale is {scale}; give one within (0, 1] that leaves at least 16 pixels a side.")
    frames = [pair.resized(size) for pair in pairs]
    resized = rig.resized(size)
    data = ScoringData(
        np.stack([frame.left for frame in frames]),
        np.stack([frame.right for frame in frames]),
        resized.left,
        resized.right,
        view.scaled(scale),
    )
    return jax.device_put(jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), data))


@register_pytree
@dataclass(frozen=True, eq=False)
class Rectified:
    """One rectified frame: images and the areas that they really cover.

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
    rotation = rotation_from_euler(extrinsics[:3])
    maps = rectifying_maps(data.left_camera, data.right_camera, rotation, extrinsics[3:], data.view)
    maps = jax.lax.optimization_barrier(maps)  # computed once, not once for each pixel that a warp reads
    areas = [area(m, c.size) for m, c in zip(maps, (data.left_camera, data.right_camera), strict=True)]

    def frame(inputs):
        *images, others = inputs
        warped = [warp(i, m) for i, m in zip(images, maps, strict=True)]
        return use(Rectified(*jax.lax.optimization_barrier(warped), *areas), *others)

    return jax.lax.map(frame, (data.left, data.right, more))


@jax.jit
def rectified_frame(data: ScoringData, extrinsics: Float[AnyArray, "6"]) -> Rectified:
    """The one frame of `data` rectified by `extrinsics`."""
    return jax.tree.map(lambda leaf: leaf[0], rectify_frames(data, extrinsics, lambda frame: frame))


def normalised(extrinsics: Extrinsics) -> Float[np.ndarray, "6"]:
    """Extrinsics with the translation as a unit vector, float64: a count does not know the unit of the baseline."""
    extrinsics = np.asarray(extrinsics, float)
    return np.concatenate([extrinsics[:3], extrinsics[3:] / np.linalg.norm(extrinsics[3:])])
