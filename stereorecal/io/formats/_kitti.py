"""What KITTI's layouts share: their calibration files, and the choice between grey and colour cameras."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._numbers import image_size, numbers
from stereorecal.io.formats._text import read_text

Content = Mapping[str, list[str]]
Sides = tuple[str, str]


def read_kitti(path: Path, archive: str) -> Content:
    """The lines `key: values` of a calibration file, as words.

    Args:
        archive: that brings the file, for the message if it is missing.

    Raises:
        InputError: if the file is missing or unreadable.
    """
    text = read_text(path, if_missing=f"download {archive} from KITTI's page and unpack it over the images.")
    lines = (line.partition(":") for line in text.splitlines())
    return {key.strip(): values.split() for key, colon, values in lines if colon}


def sides_in(folder: Path, choices: Sequence[Sides]) -> Sides:
    """The first choice of a left and a right folder that are both there.

    Raises:
        InputError: if none is.
    """
    for sides in choices:
        if all((folder / side).is_dir() for side in sides):
            return sides
    wanted = ", or ".join(f"{left} and {right}" for left, right in choices)
    raise InputError(f"{folder}: both cameras are needed, the folders {wanted}; unpack the images of the other one.")


def rectified_rig(content: Content, keys: Sides, size: tuple[int, int]) -> StereoRig:
    """The rig of images that KITTI has rectified: all cameras look the same way, `P = K [I | t]` places each.

    Between the colour cameras t differs a little in y and z as well: four cameras do not stand on one line.

    Args:
        keys: of the two 3x4 matrices P.

    Raises:
        InputError: if they are missing or cannot be a calibration.
    """
    (left, from_left), (right, from_right) = (_projection(content, key, size) for key in keys)
    return StereoRig.from_rotation(left, right, np.eye(3), from_right - from_left)


def raw_rig(content: Content, cameras: Sides) -> StereoRig:
    """The rig of the images as taken: `S K D` of each camera, and `R T` that lead from camera 00 to it.

    Args:
        cameras: their numbers, such as "00" and "01".

    Raises:
        InputError: if a key is missing or cannot be a calibration.
    """
    left, right = (
        Camera(image_size(content, f"S_{i}"), _matrix(content, f"K_{i}"), numbers(content, f"D_{i}", (-1,)))
        for i in cameras
    )
    (to_left, left_shift), (to_right, right_shift) = (
        (_matrix(content, f"R_{i}"), numbers(content, f"T_{i}", (3,))) for i in cameras
    )
    rotation = to_right @ to_left.T
    return StereoRig.from_rotation(left, right, rotation, right_shift - rotation @ left_shift)


def _matrix(content: Content, key: str) -> Mat3:
    return numbers(content, key, (9,)).reshape(3, 3)


def _projection(content: Content, key: str, size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The camera of P, and where camera 00 stands in its frame."""
    projection = numbers(content, key, (12,)).reshape(3, 4)
    with about(key):
        camera = Camera(size, projection[:, :3])
    return camera, np.linalg.solve(camera.matrix, projection[:, 3])
