"""MATLAB's stereoParameters as a struct: toStruct in a .mat file, or jsonencode in a JSON file.

MATLAB multiplies rows from the right (IntrinsicMatrix and RotationOfCamera2 are transposed; K and PoseCamera2 of newer
releases are not), counts pixels from 1, and has sizes as (rows, columns).
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import METRES, Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, pose, rig_of
from stereorecal.io.formats._numbers import image_size, numbers, value

_CAMERAS = ("CameraParameters1", "CameraParameters2")
_UNITS = {"": "mm", "millimeters": "mm", "millimetres": "mm", "mm": "mm", "centimeters": "cm", "centimetres": "cm",
          "cm": "cm", "meters": "m", "metres": "m", "m": "m", "inches": "in", "in": "in"}  # fmt: skip
_DIFFERENT = 1e-3


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a struct, wherever it is in the file; lengths in millimetres."""
    whole = documents[0].content
    content = _struct(whole) or whole
    left, right = (_camera(content[name], name, hints) for name in _CAMERAS)
    rotation, translation = _motion(content)
    word = next((content[name].get("WorldUnits") for name in _CAMERAS if content[name].get("WorldUnits")), "")
    unit = _UNITS.get(str(word).lower())
    if unit is None:
        raise InputError(f"WorldUnits is {word!r}; write one of millimeters, centimeters, meters, inches.")
    return rig_of(left, right, pose(rotation, translation * (METRES[unit] / METRES["mm"])))


def _struct(content: Any, depth: int = 0) -> Mapping[str, Any] | None:
    if not isinstance(content, Mapping) or depth > 3:
        return None
    if all(isinstance(content.get(name), Mapping) for name in _CAMERAS):
        return content
    return next((found for inside in content.values() if (found := _struct(inside, depth + 1)) is not None), None)


def _motion(content: Mapping[str, Any]) -> tuple[Mat3, Any]:
    """R and T from the first camera to the second."""
    pose, found = content.get("PoseCamera2"), []
    if "RotationOfCamera2" in content:
        found.append((numbers(content, "RotationOfCamera2", (3, 3)).T, numbers(content, "TranslationOfCamera2", (3,))))
    if isinstance(pose, Mapping):
        with about("PoseCamera2"):
            if "R" in pose:
                found.append((numbers(pose, "R", (3, 3)), numbers(pose, "Translation", (3,))))
            else:
                matrix = numbers(pose, "A", (4, 4))
                found.append((matrix[:3, :3], matrix[:3, 3]))
    if not found:
        value(content, "RotationOfCamera2")
    if any(np.abs(R - found[0][0]).max() > _DIFFERENT for R, _ in found):
        raise InputError("RotationOfCamera2 is not the transpose of PoseCamera2's R; remove the one that is wrong.")
    return found[0]


def _camera(content: Mapping[str, Any], name: str, hints: Hints) -> Camera:
    content = content["Intrinsics"] if isinstance(content.get("Intrinsics"), Mapping) else content
    with about(name):
        if "MappingCoefficients" in content:
            raise UnsupportedModelError("MATLAB's fisheye model is not supported; undistort the images.")
        matrix = numbers(content, "K", (3, 3)) if "K" in content else numbers(content, "IntrinsicMatrix", (3, 3))
        matrix = matrix if np.any(matrix[:2, 2]) else matrix.T
        matrix = matrix - np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        if content.get("ImageSize"):
            high, wide = image_size(content, "ImageSize")
        else:
            wide, high = hints.needed_size("ImageSize is empty")
        radial, tangential = (numbers(content, f"{kind}Distortion", (-1,)) for kind in ("Radial", "Tangential"))
        if radial.size not in (2, 3) or tangential.size != 2:
            raise InputError("RadialDistortion has two or three numbers, and TangentialDistortion two; correct them.")
        return Camera((wide, high), matrix, np.array([*radial[:2], *tangential, *radial[2:]]))


FORMAT = Format(
    "matlab",
    "MATLAB's stereoParameters as a struct (toStruct, jsonencode)",
    "mm",
    lambda document: _struct(document.content) is not None,
    _read,
)
