"""Images as the calibration has them: turned as their EXIF orientation says, or resampled to the other one's size."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.recordings import Pair, check_two_images, make_pair

Size = tuple[int, int]
Sizes = tuple[Size, Size]  # (width, height) of the left and of the right camera's images
Tags = tuple[int, int]  # EXIF orientations, 1 to 8; 1: upright
UPRIGHT = (1, 1)


def fitted_pair(images: Sequence[Any], tags: Tags, sizes: Sizes | None, about: str, name: str, **more: Any) -> Pair:
    """The pair of a left and a right image as OpenCV has them, in BGR order, fitted to their cameras and checked.

    Args:
        about: what errors call it.
        more: its origin and its time.
    """
    left, right = fitted(images, tags, sizes, about)
    pair = make_pair(left, right, channels="bgr", name=about, **more)
    check_two_images(pair)
    return replace(pair, name=name)


def fitted(images: Sequence[Any], tags: Tags, sizes: Sizes | None, name: str) -> tuple[Any, Any]:
    """A left and a right image of one size. Pixels are used as stored, unless only turned images have the sizes of
    their cameras (or, if these are not known, one size); the larger of two sizes is resampled to the smaller.

    Raises:
        InputError: about `name`, if the sizes differ, or are not those of cameras that differ.
    """
    stored = _size(images[0]), _size(images[1])
    if only_turned_fit(stored, tags, sizes):
        images = [_turned(image, tag) for image, tag in zip(images, tags, strict=True)]
        stored = _size(images[0]), _size(images[1])
    if sizes is not None and sizes[0] != sizes[1]:
        if stored != sizes:
            raise InputError(
                f"{name}: the images are {_text(stored)}, but the calibration is for {_text(sizes)}; use images and "
                "calibration of the same sizes."
            )
        images = [cv2.resize(image, common_size(sizes), interpolation=cv2.INTER_AREA) for image in images]
    elif stored[0] != stored[1]:
        raise InputError(
            f"{name}: the left image is {_wide(stored[0])} and the right one {_wide(stored[1])}; both must have the "
            "same size, or each that of its camera in a calibration that says one for each."
        )
    return images[0], images[1]


def common_size(sizes: Sizes) -> Size:
    """The smaller one."""
    return min(sizes, key=lambda size: size[0] * size[1])


def only_turned_fit(stored: Sizes, tags: Tags, sizes: Sizes | None) -> bool:
    """Whether images have the sizes of their cameras only once they are turned."""
    left, right = ((size[1], size[0]) if tag > 4 else size for size, tag in zip(stored, tags, strict=True))
    return not _fit(stored, sizes) and _fit((left, right), sizes)


def remark_orientation(name: str, stored: Sizes, tags: Tags, sizes: Sizes | None) -> None:
    """Say how images with an EXIF orientation are read.

    Warns:
        CalibrationWarning: if one has.
    """
    if tags == UPRIGHT:
        return
    said = f"EXIF orientation {tags[0]}" if tags[0] == tags[1] else f"EXIF orientations {tags[0]} and {tags[1]}"
    if only_turned_fit(stored, tags, sizes):
        message = f"{name}: {said} applied, since the sizes of images and calibration fit only then."
    else:
        message = (
            f"{name}: {said} not applied; the calibration may be for turned images, as cv2.imread and viewers give "
            "them: if it is, turn the files, with cv2.imwrite(name, cv2.imread(name))"
            f"{', or say --fix turned' if tags == (3, 3) else ''}."
        )
    warnings.warn(message, CalibrationWarning, stacklevel=3)


def _fit(found: Sizes, sizes: Sizes | None) -> bool:
    return found[0] == found[1] if sizes is None else found == sizes


def _turned(image: Any, tag: int) -> Any:
    """The image as a viewer shows it."""
    image = image.swapaxes(0, 1) if tag in (5, 6, 7, 8) else image
    image = image[:, ::-1] if tag in (2, 3, 6, 7) else image
    return image[::-1] if tag in (3, 4, 7, 8) else image


def _size(image: Any) -> Size:
    return image.shape[1], image.shape[0]


def _text(sizes: Sizes) -> str:
    return f"{_wide(sizes[0])} (left) and {_wide(sizes[1])} (right)"


def _wide(size: Size) -> str:
    return f"{size[0]}x{size[1]}"
