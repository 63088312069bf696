"""The data of a score: images, cameras and view at one image scale, whole or in bands of rows."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, refuse_tracers, register_pytree
from stereorecal._errors import InputError
from stereorecal.geometry import AnyView, Camera, StereoRig, View, as_view
from stereorecal.recordings import Pair, Pairs, check_pairs
from stereorecal.scoring._image_quality import ImageQuality, image_quality, select_frames

_SMALLEST = 16  # pixels a side: below that no window of a matcher fits
_COEFFICIENTS = 8  # of a pinhole camera in programs

_ROWS = 32  # of a band: its border rows see less than a window


@register_pytree
@dataclass(frozen=True, eq=False)
class ScoringData:
    """All that is fixed while extrinsics vary. A pytree: `prepare` makes it, and the pure scores take it.

    Attributes:
        left, right: (k, h, w) float32, the frames at the image scale.
        left_camera, right_camera: the cameras at that scale.
        view: the one View in which every candidate is scored, at that scale.
        scale: pixels here per pixel at full size; part of the structure, so it is known while tracing.
    """

    left: Float[AnyArray, "k h w"]
    right: Float[AnyArray, "k h w"]
    left_camera: Camera
    right_camera: Camera
    view: View
    scale: float = field(default=1.0, metadata={"static": True})

    @property
    def frames(self) -> list["ScoringData"]:
        """Each frame alone: one program then serves any number of frames."""
        if len(self.left) == 1:
            return [self]
        left, right = np.asarray(self.left), np.asarray(self.right)  # a slice of NumPy's is no program to compile
        return [replace(self, left=left[i : i + 1], right=right[i : i + 1]) for i in range(len(left))]

    def through(self, rig: StereoRig) -> "ScoringData":
        """The same frames with the cameras of another rig, given at full size."""
        scaled = rig.resized(self.left_camera.size)
        both = _filled_up(scaled.left), _filled_up(scaled.right)
        left, right = jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), both)
        return replace(self, left_camera=left, right_camera=right)

    @property
    def pixels(self) -> int:
        """Number of pixels of the view, over all frames."""
        return self.left.shape[0] * self.view.size[0] * self.view.size[1]

    @property
    def cost(self) -> float:
        """Units of one evaluation on all frames: k s² (one unit: one matcher run on one full-size frame)."""
        return len(self.left) * self.scale**2


@dataclass(frozen=True, eq=False)
class Pyramid:
    """The images of a rig at several scales, each prepared once, when it is first used.

    Attributes:
        rig: whose cameras took them.
        pairs: checked, at least one.
        view: at full size.
    """

    rig: StereoRig
    pairs: tuple[Pair, ...]
    view: View
    _levels: dict[tuple[float, int], ScoringData] = field(default_factory=dict, repr=False)

    def at(self, scale: float, most: int | None = None) -> ScoringData:
        """At most `most` pairs (default: all), those with most texture, at `scale`, on JAX's device.

        Raises:
            InputError: if the scale is not within (0, 1], or leaves less than 16 pixels a side.
        """
        number = min(len(self.pairs), most or len(self.pairs))
        if (scale, number) not in self._levels:
            self._levels[scale, number] = _prepared(self.rig, select_frames(self.pairs, number), self.view, scale)
        return self._levels[scale, number]

    @cached_property
    def quality(self) -> tuple[ImageQuality, ...]:
        """That of each pair."""
        return tuple(map(image_quality, self.pairs))

    @property
    def best_quality(self) -> ImageQuality:
        """That of the pair with most texture."""
        return max(self.quality, key=lambda one: one.texture)

    @property
    def enough(self) -> bool:
        """Whether a pair of an aligned rig would match."""
        return any(one.enough for one in self.quality)


def pyramid(rig: StereoRig, pairs: Pairs, view: AnyView = None) -> Pyramid:
    """The pyramid of pairs that `rig` took.

    Args:
        view: default the view of `rig`; also the arguments of `sr.view` by name.

    Raises:
        InputError: if images and calibration do not fit, or the view makes no sense.
    """
    return Pyramid(rig, check_pairs(rig, pairs), as_view(view, rig))


def prepare(rig: StereoRig, pairs: Pairs, view: AnyView = None, scale: float = 1.0) -> ScoringData:
    """Images, cameras and view resampled to `scale` and put on JAX's device, for the pure scores: `sr.count`,
    `sr.soft_count`, `sr.correspondences`. Works on the host.

    Args:
        pairs: one or several; all are scored together.
        view: at full size; default the view of `rig`; also the arguments of `sr.view` by name.
        scale: image scale, (0, 1].

    Raises:
        InputError: if images and calibration do not fit, or the scale leaves no image.
    """
    instead = "it before tracing, and vary the extrinsics of sr.count or sr.soft_count"
    refuse_tracers("sr.prepare", instead, rig, pairs, view)
    return pyramid(rig, pairs, view).at(scale)  # extrinsics of a rig that was turned would be other ones


def _prepared(rig: StereoRig, pairs: Sequence[Pair], view: View, scale: float) -> ScoringData:
    width, height = rig.left.size
    size = (round(width * scale), round(height * scale)) if 0.0 < scale <= 1.0 else (0, 0)
    if min(width, height) < _SMALLEST:
        raise InputError(f"the images are {width}x{height}; give some of at least {_SMALLEST} pixels a side.")
    if min(size) < _SMALLEST:
        raise InputError(f"scale is {scale}; give one within (0, 1] that leaves at least {_SMALLEST} pixels a side.")
    frames = [pair.resized(size) for pair in pairs]
    resized = rig.resized(size)
    data = ScoringData(
        np.stack([frame.left for frame in frames]),
        np.stack([frame.right for frame in frames]),
        _filled_up(resized.left),
        _filled_up(resized.right),
        view.scaled(scale),
        float(scale),
    )
    return jax.device_put(jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), data))


def _filled_up(camera: Camera) -> Camera:
    """The same lens with zeros for coefficients that it has not: lenses with 0, 4, 5 or 8 share compiled programs."""
    missing = _COEFFICIENTS - len(camera.distortion)
    if camera.lens.WIDE or missing <= 0:
        return camera
    return replace(camera, distortion=np.pad(camera.distortion, (0, missing)))


def bands(data: ScoringData, share: float) -> tuple[ScoringData, ...]:
    """Bands of 32 rows, evenly spread over the view, that make up about `share` of it; at 1, the view itself.

    Scores of the bands add up. Pixels between them are never rectified.

    Raises:
        InputError: if the share is not within (0, 1].
    """
    if not 0.0 < share <= 1.0:
        raise InputError(f"rows is {share}; give the share of the rows that are scored, within (0, 1].")
    width, height = data.view.size
    number = max(1, round(share * height / _ROWS))
    if number * _ROWS >= height:
        return (data,)
    firsts = np.round((np.arange(number) + 0.5) * height / number - _ROWS / 2)
    views = (replace(data.view, size=(width, _ROWS), centre_row=data.view.centre_row - np.float32(f)) for f in firsts)
    return tuple(replace(data, view=view) for view in views)
