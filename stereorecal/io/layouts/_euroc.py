"""EuRoC, and what else is laid out like it (ASL): cameras with their places on the body."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._file_storage import read_file_storage
from stereorecal.io.formats._numbers import image_size, numbers, value
from stereorecal.io.images._matched import Matched, by_stem, load_matched
from stereorecal.io.layouts._sequences import log_of
from stereorecal.recordings import Log

LAYOUT = "EuRoC or ASL (mav0/cam0 and cam1, each with sensor.yaml and data/TIME.png)"
_PINHOLE = ("radial-tangential", "radtan", "plumb_bob")


def recognises(folder: Path) -> bool:
    """Whether the folder is mav0 or contains it."""
    return _body(folder) is not None


def read(folder: Path, limit: int | None) -> Log:
    """The frames of cam0 (left) and cam1 that were taken at the same time; EuRoC has some from one camera only.

    Raises:
        InputError: naming the file, if something is missing or damaged.
        UnsupportedModelError: if the camera is no pinhole with radial-tangential distortion.
    """
    body = _body(folder) or folder
    pairs = load_matched(_same_time(body / "cam0" / "data", body / "cam1" / "data"), limit)
    return log_of(folder, [(folder, _rig(body), pairs)])


def _body(folder: Path) -> Path | None:
    return next((body for body in (folder / "mav0", folder) if (body / "cam0" / "data").is_dir()), None)


def _same_time(left: Path, right: Path) -> Matched:
    left_files, right_files = by_stem(left), by_stem(right)
    matched = [(path, right_files[time]) for time, path in left_files.items() if time in right_files]
    if not matched:
        raise InputError(f"{left}: no image in there has the time, that is the name, of one in {right}; check both.")
    return matched


def _rig(body: Path) -> StereoRig:
    """x_right = R x_left + T, from the places of both cameras: x_body = R_i x_i + T_i."""
    (left, left_axes, left_place), (right, right_axes, right_place) = (
        _camera(body / name / "sensor.yaml") for name in ("cam0", "cam1")
    )
    with about(body):
        return StereoRig.from_rotation(left, right, right_axes.T @ left_axes, right_axes.T @ (left_place - right_place))


def _camera(path: Path) -> tuple[Camera, Mat3, Vec3]:
    content = read_file_storage(path)
    with about(path):
        _check_model(content)
        fx, fy, cx, cy = numbers(content, "intrinsics", (4,))
        matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
        camera = Camera(image_size(content, "resolution"), matrix, numbers(content, "distortion_coefficients", (-1,)))
        place = numbers(content, "T_BS", (4, 4))
    return camera, place[:3, :3], place[:3, 3]


def _check_model(content: Mapping[str, Any]) -> None:
    camera, distortion = (value(content, key) for key in ("camera_model", "distortion_model"))
    if camera != "pinhole" or distortion not in _PINHOLE:
        raise UnsupportedModelError(
            f"the camera model {camera!r} with the distortion model {distortion!r} is not supported; calibrate as "
            "pinhole with radial-tangential distortion."
        )
