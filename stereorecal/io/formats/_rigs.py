"""A rig without images: the file that holds its calibration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._atomic import write_text
from stereorecal.io._paths import AnyPath
from stereorecal.io.formats._calib_json import calibration_of, calibration_text, load_calibration
from stereorecal.io.formats._units import warn_of_units


def load_rig(path: AnyPath) -> StereoRig:
    """The rig in a calib.json (for its keys see `load_scene`).

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's pinhole model.

    Warns:
        CalibrationWarning: if the baseline is longer than 5 m or shorter than 5 mm, as of a rig in other units.
    """
    rig = load_calibration(Path(path)).rig
    if rig is None:
        raise InputError(f"{path}: the camera matrices are null; give a file with a calibration.")
    warn_of_units(path, rig)
    return rig


def save_rig(rig: StereoRig, path: AnyPath, info: Mapping[str, Any] | None = None, overwrite: bool = False) -> None:
    """Write a rig as a calib.json, whole or not at all. `load_rig` returns the same extrinsics to within 1e-12.

    Args:
        info: other keys to write, such as `Scene.info`; those that describe the rig are replaced.
        overwrite: whether an existing file may be replaced.

    Raises:
        InputError: if the file exists already, the place cannot be written to, the cameras differ in image size, or
            JSON cannot hold a value of `info`. Nothing is written then.
    """
    if rig.left.size != rig.right.size:
        raise InputError(
            f"the cameras have images of {_size(rig.left)} and {_size(rig.right)}, but a calib.json has one size for "
            "both; resize the images of one, and its camera with `Camera.resized`."
        )
    text = calibration_text({**(info or {}), **calibration_of(rig, rig.left.size)})
    if Path(path).exists() and not overwrite:
        raise InputError(f"{path}: the file exists already; choose another name or allow overwriting.")
    write_text(path, text)


def _size(camera: Camera) -> str:
    return f"{camera.size[0]}x{camera.size[1]}"
