"""KITTI's calibration files (calib_cam_to_cam.txt, calib.txt): lines `key: values`."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from stereorecal._arrays import Mat3, Vec3
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io._text import read_text
from stereorecal.io.formats._numbers import image_size, number_or_word, numbers

Content = Mapping[str, list[float | str]]


def read_kitti(path: Path, archive: str) -> Content:
    """The lines of a calibration file by their keys: numbers, and words where they are none.

    Args:
        archive: the download that contains the file, named in the message if it is missing.

    Raises:
        InputError: naming the file, if it is missing or unreadable.
    """
    text = read_text(path, if_missing=f"download {archive} from KITTI's page and unpack it over the images.")
    lines = (line.partition(":") for line in text.splitlines())
    return {key.strip(): [number_or_word(word) for word in values.split()] for key, colon, values in lines if colon}


def rectified_rig(content: Content, keys: tuple[str, str], size: tuple[int, int]) -> StereoRig:
    """The rig of images that KITTI has rectified: all cameras have the same orientation, `P = K [I | t]` places each.

    Between the colour cameras t differs slightly in y and z too: the four cameras are not exactly on one line.

    Args:
        keys: of the left and the right 3x4 projection matrix.
        size: (width, height) of the images.

    Raises:
        InputError: if a matrix is missing, or they are not a valid calibration.
    """
    (left, from_left), (right, from_right) = (_projection(content, key, size) for key in keys)
    return StereoRig.from_rotation(left, right, np.eye(3), from_right - from_left)


def raw_rig(content: Content, cameras: tuple[str, str]) -> StereoRig:
    """The rig of the raw images: `S K D` of each camera, and `R T` from camera 00 to it.

    Args:
        cameras: the numbers of the left and the right camera, such as "00" and "01".

    Raises:
        InputError: if a key is missing, or the values are not a valid calibration.
        UnsupportedModelError: if the number of distortion coefficients is not one of OpenCV's pinhole model.
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
    """The camera of P, and the position t of camera 00 in its frame."""
    projection = numbers(content, key, (12,)).reshape(3, 4)
    with about(key):
        camera = Camera(size, projection[:, :3])
    return camera, np.linalg.solve(camera.matrix, projection[:, 3])
