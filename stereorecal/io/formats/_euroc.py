"""EuRoC's sensor.yaml (ASL format): one camera, its intrinsics and its pose on the body."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._file_storage import read_file_storage
from stereorecal.io.formats._numbers import image_size, numbers, value

# The name in EuRoC's files, and those of Kalibr and ROS for the same model: OpenCV's k1 k2 p1 p2.
_RADIAL_TANGENTIAL = ("radial-tangential", "radtan", "plumb_bob")


def load_euroc(left: Path, right: Path) -> StereoRig:
    """The rig of two sensor.yaml files. Each has the pose `T_BS` of its camera: x_body = R_i x_i + T_i, in metres.

    Raises:
        InputError: naming the file, if one cannot be read or does not hold a valid calibration.
        UnsupportedModelError: if a camera is not a pinhole with radial-tangential distortion.
    """
    (left_camera, left_axes, left_place), (right_camera, right_axes, right_place) = _camera(left), _camera(right)
    with about(f"{left} and {right}"):
        return StereoRig.from_rotation(
            left_camera, right_camera, right_axes.T @ left_axes, right_axes.T @ (left_place - right_place)
        )


def _camera(path: Path) -> tuple[Camera, Mat3, Vec3]:
    """A camera, and the rotation and translation of its pose on the body."""
    content = read_file_storage(path)
    with about(path):
        _check_model(content)
        fx, fy, cx, cy = numbers(content, "intrinsics", (4,))
        matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
        camera = Camera(image_size(content, "resolution"), matrix, numbers(content, "distortion_coefficients", (-1,)))
        pose = numbers(content, "T_BS", (4, 4))
    return camera, pose[:3, :3], pose[:3, 3]


def _check_model(content: Mapping[str, Any]) -> None:
    camera, distortion = (value(content, key) for key in ("camera_model", "distortion_model"))
    if camera != "pinhole" or distortion not in _RADIAL_TANGENTIAL:
        raise UnsupportedModelError(
            f"the camera model {camera!r} with the distortion model {distortion!r} is not supported; calibrate as "
            "pinhole with radial-tangential distortion."
        )
