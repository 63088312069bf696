"""A rig alone: reading and writing a calib.json without its images."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._atomic import write_text
from stereorecal.io.formats._calib_json import calibration_of, calibration_text, load_calibration
from stereorecal.io.images._pairs import AnyPath


def load_rig(path: AnyPath) -> StereoRig:
    """The rig that a calib.json describes (keys: see `load_scene`).

    Raises:
        InputError: naming the file, if it cannot be read or holds no calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's.
    """
    rig = load_calibration(Path(path)).rig
    if rig is None:
        raise InputError(f"{path}: the camera matrices are null; give a file with a calibration.")
    return rig


def save_rig(rig: StereoRig, path: AnyPath, info: Mapping[str, Any] | None = None, overwrite: bool = False) -> None:
    """Write a rig as a calib.json, whole or not at all; the extrinsics come back to 1e-12.

    Args:
        info: other keys to carry along, such as `Scene.info`; keys of the rig win.
        overwrite: whether a file that is there may be replaced.

    Raises:
        InputError: if a file is there already, the place cannot be written to, the cameras differ in image size, or
            `info` cannot be written as JSON. Nothing is written then.
    """
    if rig.left.size != rig.right.size:
        raise InputError(
            f"the cameras have images of {rig.left.size} and {rig.right.size}; a calib.json has one size for both."
        )
    text = calibration_text({**(info or {}), **calibration_of(rig, rig.left.size)})
    if Path(path).exists() and not overwrite:
        raise InputError(f"{path}: the file exists already; choose another name or allow overwriting.")
    write_text(path, text + "\n")
