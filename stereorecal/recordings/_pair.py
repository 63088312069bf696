"""One pair of images, taken at the same time, at once or row by row."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Float, Num

from stereorecal._errors import InputError
from stereorecal.geometry import UPRIGHT, Turns, whole_size
from stereorecal.recordings._cv2 import cv2

_LONGEST_READOUT = 1.0  # seconds
_WHITE, _ROUNDING = 255.0, 0.5
_USUAL, _HOT, _SOME = 0.9999, 2.0, 4  # share of the pixels; times as bright as these; every so many rows and columns
# Rec. 601 luma, as OpenCV's.
_LUMA = {"rgb": (0.299, 0.587, 0.114), "bgr": (0.114, 0.587, 0.299)}


@dataclass(frozen=True, eq=False)
class Pair:
    """One synchronous pair of grey images, (h, w) float32 in 0..255.

    Attributes:
        left, right: the images; use `make_pair` for colour or more than 8 bit.
        name: what people call the pair.
        origin: None, or (function, arguments) that make the pair again: a pair that came from files is pickled as
            its paths, not as pixels.
        time: when it was taken, seconds of any clock; None if that is not known.
        readout: seconds that rolling shutters take from the first row to the last; 0: all rows at once.
        turns: by how many quarters the images are turned, as a rig has it; (0, 0): as they were taken.

    Raises:
        InputError: if the images differ in size, are empty, contain NaN or infinite values, or are constant, the time
            is not finite, or the readout makes no sense or is of images that are turned.
    """

    left: Float[np.ndarray, "h w"]
    right: Float[np.ndarray, "h_right w_right"]  # the same, or an InputError says otherwise
    name: str = "pair"
    origin: tuple[Callable[..., "Pair"], tuple[Any, ...]] | None = field(default=None, repr=False)
    time: float | None = None
    readout: float = 0.0
    turns: Turns = UPRIGHT

    def __post_init__(self) -> None:
        if not (_is_number(self.readout) and 0.0 <= self.readout <= _LONGEST_READOUT):
            raise InputError(
                f"{self.name}: a rolling shutter that reads an image in {self.readout!r} s makes no sense; give 0 to "
                f"{_LONGEST_READOUT:g} s."
            )
        if self.readout and self.turns != UPRIGHT:
            raise InputError(
                f"{self.name}: the images are turned, and a rolling shutter takes those as they are row by row; leave "
                "the readout out."
            )
        if self.time is not None and not (_is_number(self.time) and np.isfinite(self.time)):
            raise InputError(f"{self.name}: a time of {self.time!r} s makes no sense; leave it out if it is not known.")
        for side in ("left", "right"):
            image = _numbers(getattr(self, side), f"{self.name}, {side}").astype(np.float32, copy=False)
            if image.ndim != 2:
                raise InputError(
                    f"{self.name}: an image of shape {image.shape} is not grey; write sr.make_pair(left, right), "
                    "which takes colour and up to 16 bit."
                )
            object.__setattr__(self, side, image)
        if self.left.shape != self.right.shape:
            raise InputError(
                f"{self.name}: the left image is {_size_text(self.left)} and the right one {_size_text(self.right)}; "
                "both must have the same size."
            )
        for side, image in (("left", self.left), ("right", self.right)):
            if not image.size:
                raise InputError(f"{self.name}, {side}: the image has no pixels; check camera and file.")
            darkest, brightest = float(image.min()), float(image.max())  # NaN if there is one
            if not np.isfinite(brightest - darkest):
                raise InputError(f"{self.name}, {side}: the image contains NaN or infinite values; replace them.")
            if darkest < -_ROUNDING:
                raise InputError(f"{self.name}, {side}: the image contains negative values; shift or clip them.")
            if brightest > _WHITE + _ROUNDING:
                raise InputError(
                    f"{self.name}, {side}: grey levels go up to {brightest:g}, and those of a Pair to 255; "
                    "write sr.make_pair(left, right), which scales them."
                )
            if darkest == brightest:
                kind = "all black" if brightest == 0 else "constant"
                raise InputError(
                    f"{self.name}, {side}: the image is {kind}; there is nothing to match: check camera and file."
                )

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.left.shape[1], self.left.shape[0]

    def resized(self, size: tuple[int, int]) -> "Pair":
        """The pair resampled to `size` (width, height), whole pixels, by area averaging."""
        size = whole_size(size)
        if size == self.size:
            return self
        left, right = (cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in (self.left, self.right))
        return replace(self, left=left, right=right, origin=None)

    def read_out(self, seconds: float) -> "Pair":
        """The pair as rolling shutters took it that take so many seconds from the first row to the last."""
        return self._but("read_out", seconds, readout=seconds)

    def turned(self, turns: Turns) -> "Pair":
        """The pair with its left and right image turned counter-clockwise by so many quarters more.

        Raises:
            InputError: if they have different sizes then, or rolling shutters took them.
        """
        if turns == UPRIGHT:
            return self
        left, right = (
            np.ascontiguousarray(np.rot90(image, turn))
            for image, turn in zip((self.left, self.right), turns, strict=True)
        )
        now = (self.turns[0] + turns[0]) % 4, (self.turns[1] + turns[1]) % 4
        return self._but("turned", turns, left=left, right=right, turns=now)

    def as_taken(self) -> "Pair":
        """The pair as it was taken."""
        return self.turned((-self.turns[0] % 4, -self.turns[1] % 4))

    def named(self, name: str) -> "Pair":
        """The pair under another name."""
        return self._but("named", name, name=name)

    def _but(self, method: str, argument: Any, **changes: Any) -> "Pair":
        """The pair with what a method of it changes, which does so again where the pair arrives."""
        origin = None if self.origin is None else (_again, (self.origin, method, argument))
        return replace(self, origin=origin, **changes)

    def __reduce__(self):
        if self.origin is not None:
            return self.origin
        return Pair, (self.left, self.right, self.name, None, self.time, self.readout, self.turns)


def _again(origin: tuple[Callable[..., Pair], tuple[Any, ...]], method: str, argument: Any) -> Pair:
    """What a method made of a pair, where it arrives."""
    make, arguments = origin
    return getattr(make(*arguments), method)(argument)


def make_pair(
    left: Num[np.ndarray, "..."] | Any,  # what is no array of numbers an InputError refuses
    right: Num[np.ndarray, "..."] | Any,
    *,
    channels: str = "rgb",
    name: str = "pair",
    origin: tuple[Callable[..., Pair], tuple[Any, ...]] | None = None,
    time: float | None = None,
) -> Pair:
    """A pair of two images as `cv2.imread`, imageio or a camera's driver give them: grey (h, w) or colour (h, w, 3 or
    4), of 8 to 16 bit or floating point.

    8-bit values stay as they are. Anything wider is scaled once for both images, so that their common maximum is 255;
    of integers, single pixels (one of 10 000) that are more than twice as bright as all others, hot ones, do not count.

    Args:
        channels: "rgb" or "bgr", the order of the first three channels of colour images.
        time: when it was taken, in seconds, if that is known: consecutive pairs then tell depth.

    Raises:
        InputError: if sizes or depths differ, values are NaN, infinite or negative, or an image is constant or None.
    """
    if channels not in _LUMA:
        raise InputError(f"unknown channel order {channels!r}; use 'rgb' or 'bgr'.")
    left, right = _numbers(left, f"{name}, left"), _numbers(right, f"{name}, right")
    eight_bit = left.dtype == np.uint8
    depths = [(image.dtype.kind, image.dtype.kind == "f" or image.dtype.itemsize) for image in (left, right)]
    if depths[0] != depths[1]:
        raise InputError(
            f"{name}: the left image is {left.dtype} and the right one {right.dtype}; give both the same bit depth."
        )
    grey_left, grey_right = (
        _grey(image, channels, f"{name}, {side}") for image, side in ((left, "left"), (right, "right"))
    )
    if not eight_bit:
        scale = _WHITE / _white_of((grey_left, grey_right), from_sensor=left.dtype.kind != "f")
        grey_left, grey_right = (np.minimum(image * scale, _WHITE) for image in (grey_left, grey_right))
    return Pair(grey_left.astype(np.float32), grey_right.astype(np.float32), name, origin, time)


def _white_of(images: Sequence[np.ndarray], *, from_sensor: bool) -> float:
    """The value that becomes white: the largest; of a sensor without those of hot pixels."""
    largest = max(float(image.max()) for image in images)
    if from_sensor:
        usual = max(float(np.quantile(image[::_SOME, ::_SOME], _USUAL, method="lower")) for image in images)
        largest = largest if largest <= _HOT * usual or usual <= 0.0 else usual
    return max(largest, 1e-30)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) or (np.ndim(value) == 0 and getattr(value, "dtype", np.dtype(object)).kind in "uif")


def _numbers(image: Any, name: str) -> np.ndarray:
    """An image as an array of numbers."""
    if image is None:
        raise InputError(f"{name}: None is no image; cv2.imread returns it where it cannot read: check the path.")
    if isinstance(image, np.ma.MaskedArray):
        raise InputError(f"{name}: the image is a masked array; give a plain one, without NaN: image.filled(0).")
    try:
        array = np.asarray(image)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InputError(f"{name}: a {type(image).__name__} is no array ({error}); give one of NumPy's.") from None
    if array.dtype.kind not in "buif":
        what = f"an array of {array.dtype}" if isinstance(image, np.ndarray) else f"a {type(image).__name__}"
        raise InputError(f"{name}: {what} is no image; give an array of grey levels (h, w), or colours (h, w, 3).")
    return array


def _grey(image: np.ndarray, channels: str, name: str) -> np.ndarray:
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[..., 0]
    if not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] in (3, 4))) or min(image.shape[:2]) < 2:
        raise InputError(f"{name}: an array of shape {image.shape} is no image; give (h, w) or (h, w, 3).")
    if image.dtype.kind == "f" and not np.isfinite(image).all():
        raise InputError(f"{name}: the image contains NaN or infinite values; replace them.")
    if image.min() < 0:
        raise InputError(f"{name}: the image contains negative values; shift or clip them.")
    if image.ndim == 3:
        image = image[..., :3].astype(np.float32) @ np.array(_LUMA[channels], np.float32)
    return image.astype(np.float32)


def _size_text(image: np.ndarray) -> str:
    return f"{image.shape[1]}x{image.shape[0]}"


def share_of(first: Pair, second: Pair) -> float:
    """The readout as a share of the time between two pairs; 0 where all rows are taken at once.

    Raises:
        InputError: if that time is not known, or not longer than the readout.
    """
    readout = max(first.readout, second.readout)
    if not readout:
        return 0.0
    if first.time is None or second.time is None or second.time - first.time < readout:
        raise InputError(
            f"{first.name} and {second.name}: rolling shutters read an image in {readout:g} s, and the pairs do not "
            "know times that are at least as far apart; give times, leave the readout (readout_s) out, or say "
            "motion=False (--motion off)."
        )
    return readout / (second.time - first.time)
