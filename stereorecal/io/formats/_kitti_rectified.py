"""The rig of images that KITTI has rectified: projection matrices `P = K [I | t]`, row-major on a line."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Vec3
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._numbers import numbers
from stereorecal.io.formats._rigid_motions import pose, rig_of


def rectified_rig(content: Mapping[str, Any], keys: tuple[str, str], size: tuple[int, int]) -> StereoRig:
    """All cameras have the same orientation, and P places each of them.

    Between the colour cameras t differs slightly in y and z too: the four cameras are not exactly on one line.

    Args:
        keys: of the left and the right 3x4 projection matrix.
        size: (width, height) of the images.

    Raises:
        InputError: if a matrix is missing, or they are not a valid calibration.
    """
    (left, from_left), (right, from_right) = (camera_and_place(content, key, size) for key in keys)
    return rig_of(left, right, pose(np.eye(3), from_right - from_left))


def camera_and_place(content: Mapping[str, Any], key: str, size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The camera of P, and the position t of camera 00 in its frame."""
    projection = numbers(content, key, (12,)).reshape(3, 4)
    with about(key):
        return in_projection(projection, size)


def in_projection(projection: Float[np.ndarray, "3 4"], size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The rectified camera K of P = K [I | t], and t.

    Raises:
        InputError: if K is no camera matrix.
    """
    camera = Camera(size, projection[:, :3])
    return camera, np.linalg.solve(camera.matrix, projection[:, 3])
