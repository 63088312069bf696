"""Image pairs from files; as the calibration has them: turned as their EXIF orientation says, or resampled to the other
one's size."""

import glob
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2

from stereorecal._errors import CalibrationWarning, InputError, check_exists, warn
from stereorecal.io._read_files import AnyPath, note_input
from stereorecal.io.images._frame_source import counted_times
from stereorecal.io.images._image_files import image_bytes, images_in, natural_order, read_image
from stereorecal.io.images._match_by_name import Matched
from stereorecal.recordings import LazyPairs, Pair, check_two_images, make_pair

Size = tuple[int, int]
Sizes = tuple[Size, Size]  # (width, height) of the left and of the right camera's images
Shot = tuple[Any, int]  # an image as OpenCV has it, in BGR order, and its EXIF orientation, 1 to 8
_EXIF = (b"Exif", b"eXIf", b"EXIF")  # what files that state one have in them: JPEG, PNG, WebP


def fitted_pair(shots: Sequence[Shot], sizes: Sizes | None, about: str, name: str, **more: Any) -> Pair:
    """The pair of a left and a right image, fitted to their cameras and checked.

    Pixels are used as stored, unless only turned images have the sizes of their cameras (or, if these are not known,
    one size); the larger of two sizes is resampled to the smaller. Errors are about `about`.
    """
    turned = _only_turned_fit(shots, sizes)
    left, right = images = [_turned(*shot) if turned else shot[0] for shot in shots]
    if sizes is not None and sizes[0] != sizes[1]:
        if _sizes(images) != sizes:
            found, wanted = (
                f"{one[0]}x{one[1]} (left) and {other[0]}x{other[1]} (right)" for one, other in (_sizes(images), sizes)
            )
            raise InputError(
                f"{about}: the images are {found}, but the calibration is for {wanted}; use images and calibration of "
                "the same sizes."
            )
        left, right = (cv2.resize(image, common_size(sizes), interpolation=cv2.INTER_AREA) for image in images)
    elif left.shape[:2] != right.shape[:2]:
        one, other = (f"{width}x{height}" for width, height in _sizes(images))
        raise InputError(
            f"{about}: the left image is {one} and the right one {other}; both must have the same size, or each that "
            "of its camera in a calibration that says one for each."
        )
    pair = make_pair(left, right, channels="bgr", name=about, **more)
    check_two_images(pair)
    return replace(pair, name=name)


def common_size(sizes: Sizes) -> Size:
    """The smaller one."""
    return min(sizes, key=lambda size: size[0] * size[1])


def _sizes(images: Sequence[Any]) -> Sizes:
    left, right = ((image.shape[1], image.shape[0]) for image in images)
    return left, right


def _only_turned_fit(shots: Sequence[Shot], sizes: Sizes | None) -> bool:
    """Whether images have the sizes of their cameras only once they are turned."""
    as_stored, turned = _sizes([image for image, _ in shots]), _sizes([_turned(*shot) for shot in shots])
    if sizes is None:
        return as_stored[0] != as_stored[1] and turned[0] == turned[1]
    return as_stored != sizes and turned == sizes


def _turned(image: Any, tag: int) -> Any:
    """The image as a viewer shows it."""
    image = image.swapaxes(0, 1) if tag in (5, 6, 7, 8) else image
    image = image[:, ::-1] if tag in (2, 3, 6, 7) else image
    return image[::-1] if tag in (3, 4, 7, 8) else image


def load_pair(left_path: AnyPath, right_path: AnyPath, time: float | None = None) -> Pair:
    """One pair from two image files: grey or colour, 8 or 16 bit, any format OpenCV reads.

    The pair is named after the left file, and is pickled as its two absolute paths. Pixels are used as stored; only
    where EXIF orientations turn the images to one size, turned.

    Args:
        time: when it was taken, in seconds, if that is known.

    Raises:
        InputError: if a file is missing, empty, truncated or not an image, if the two images differ in size or
            bit depth or do not differ at all, or if one is constant.

    Warns:
        CalibrationWarning: if an image has an EXIF orientation; it says how it is used.
    """
    left, right = os.path.abspath(left_path), os.path.abspath(right_path)
    _remark(left, right, None)
    return read_pair(left, right, time, None)


def read_pair(left: str, right: str, time: float | None, sizes: Sizes | None) -> Pair:
    """The pair of two files, fitted to cameras of these sizes; without remarks, since it is read again and again."""
    if left == right:
        raise InputError(f"{left}: this file is both the left and the right image; give two files.")
    shots, origin = (read_image(left), read_image(right)), (read_pair, (left, right, time, sizes))
    return fitted_pair(shots, sizes, f"{left} and {right}", Path(left).name, origin=origin, time=time)


def _remark(left: str, right: str, sizes: Sizes | None) -> None:
    """Say how images with an EXIF orientation are read; what is wrong with a file is said when it is used."""
    try:
        if not any(name in image_bytes(path) for path in (left, right) for name in _EXIF):
            return  # without decoding them
        shots = (_, first), (_, second) = read_image(left), read_image(right)
    except InputError:
        return
    if first == second == 1:
        return
    if _only_turned_fit(shots, sizes):
        what = "applied, since the sizes of images and calibration fit only then."
    else:
        what = (
            "not applied; the calibration may be for turned images, as cv2.imread and viewers give them: if it is, "
            "turn the files, with cv2.imwrite(name, cv2.imread(name))"
            f"{', or say --fix turned' if first == second == 3 else ''}."
        )
    said = f"EXIF orientation {first}" if first == second else f"EXIF orientations {first} and {second}"
    warn(f"{left if first > 1 else right}: {said} {what}", CalibrationWarning)


def load_matched(
    matched: Matched, limit: int | None = None, times: Sequence[float] | None = None, sizes: Sizes | None = None
) -> LazyPairs:
    """The pairs of matched files, the first `limit` or all; each is read by `load_pair` when it is used. All of the
    files count as inputs at once.

    Args:
        times: of the pairs, in seconds; default their names, if all are such numbers as `open_pairs` says.
        sizes: of the cameras, to which images are fitted.

    Raises:
        InputError: if the limit leaves none.

    Warns:
        CalibrationWarning: if the first images have an EXIF orientation.
    """
    check_limit(limit)
    for path in (path for paths in matched for path in paths):
        note_input(path)
    # Absolute: they are read where the working directory may be another.
    files = [(os.path.abspath(left), os.path.abspath(right)) for left, right in matched[:limit]]
    names = [Path(left).name for left, _ in files]
    if times is None:
        times = counted_times([Path(name).stem for name in names])
    known = [None] * len(files) if times is None else [float(time) for time in times[: len(files)]]
    if files:
        _remark(*files[0], sizes)
    reads = [partial(read_pair, *paths, time, sizes) for paths, time in zip(files, known, strict=True)]
    return LazyPairs(reads, names, known)


def check_limit(limit: int | None) -> None:
    """Refuse a number of pairs that leaves none."""
    if limit is not None and limit < 1:
        raise InputError(f"the limit of {limit} pairs leaves none; give 1 or more.")


def find_images(where: AnyPath) -> list[Path]:
    """The image files of a glob pattern, a folder or a file, in natural order."""
    path = Path(where)
    if path.is_file():
        return [path]
    found = images_in(path) or natural_order(Path(name) for name in glob.glob(str(where), recursive=True))
    found = [path for path in found if path.is_file()]
    if not found:
        check_exists(where, "file or folder")
        raise InputError(
            f"{where}: no image matches; give a file, a folder of images or a pattern such as 'left/*.png'."
        )
    return found
