"""ZED's factory calibration, SN….conf: an INI file with the cameras at each of its resolutions.

As Stereolabs' own calibration tool writes it: RX, CV and RZ are the rotation vector of OpenCV's R, Baseline is -T[0],
TY and TZ are T[1] and T[2].
"""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, pose, rig_of
from stereorecal.io.formats._numbers import numbers, pinhole_matrix, scalars, value
from stereorecal.io.formats.text._document import Document

_SIZES = {"VGA": (672, 376), "HD": (1280, 720), "FHD": (1920, 1080), "2K": (2208, 1242), "SVGA": (960, 600),
          "FHD1200": (1920, 1200), "QHDPLUS": (3200, 1800), "4K": (3840, 2160)}  # fmt: skip
_LENS = ("K1", "K2", "P1", "P2", "K3", "K4", "K5", "K6", "S1", "S2", "S3", "S4")
_FISHEYE = ("K1", "K2", "K3", "K4")
_SIDES = ("LEFT", "RIGHT")
_WIDEST = 0.1  # radians between the two cameras


def _looks(document: Document) -> bool:
    """Whether there is a left or a right camera at one of the resolutions, and the section of both."""
    keys = document.content.keys()
    return "STEREO" in keys and any(f"{side}_CAM_{name}" in keys for side in _SIDES for name in _SIZES)


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig at the resolution of the images."""
    content = documents[0].content
    modes = {size: name for name, size in _SIZES.items() if all(f"{side}_CAM_{name}" in content for side in _SIDES)}
    size = hints.mode_among(tuple(modes))
    left, right = (_camera(content, side, modes[size], size) for side in _SIDES)
    with about("STEREO"):
        stereo = content["STEREO"]
        turn = scalars(stereo, [f"{axis}_{modes[size]}" for axis in ("RX", "CV", "RZ")])
        if np.abs(turn).max() > _WIDEST:
            raise InputError(
                f"RX, CV and RZ are in radians, and the cameras of a ZED are not turned by {np.abs(turn).max():.3g} to "
                "each other; download the file again."
            )
        baseline = float(numbers(stereo, "BASELINE", ()))
        if not baseline > 0.0:
            raise InputError(f"Baseline is {baseline:g}; it is the distance of the cameras in millimetres: correct it.")
        y, z = (_aside(stereo, axis, modes[size]) for axis in ("TY", "TZ"))
    return rig_of(left, right, pose(cv2.Rodrigues(turn)[0], np.array([-baseline, y, z])))


def _aside(stereo: Mapping[str, Any], axis: str, name: str) -> float:
    """TY or TZ, which old files have for each resolution, and older ones not at all."""
    key = next((key for key in (f"{axis}_{name}", axis) if key in stereo), None)
    return 0.0 if key is None else float(numbers(stereo, key, ()))


def _camera(content: Mapping[str, Any], side: str, name: str, size: tuple[int, int]) -> Camera:
    section, shared = f"{side}_CAM_{name}", f"{side}_DISTO"
    with about(section):
        camera = content[section]
        own = {key: camera[key] for key in _LENS if key in camera}
        lens = content.get(shared, own)
        if any(lens.get(key, 0.0) != number for key, number in own.items()):
            raise InputError(f"its lens is not the one in {shared}; remove the one that is wrong.")
        with about(shared if shared in content else "lens"):
            value(lens, "K1")
            fisheye = "K4" in lens and "P1" not in lens  # the tool writes these four, and no others, of a fisheye
            names = _FISHEYE if fisheye else _LENS
            distortion = scalars(dict.fromkeys(names, 0.0) | lens, names)
        matrix = pinhole_matrix(scalars(camera, ("FX", "FY", "CX", "CY")))
        return Camera(size, matrix, distortion, model="equidistant" if fisheye else Camera.model)


FORMAT = Format(
    "zed",
    "ZED's factory calibration, SN….conf (LEFT_CAM_HD, RIGHT_CAM_HD, STEREO)",
    "mm",
    _looks,
    _read,
)
