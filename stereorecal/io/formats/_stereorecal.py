"""calib.json: the calibration of a scene folder, and the format in which this library writes a rig by default."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import JSON, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._numbers import image_size, model_named, numbers, optional, value
from stereorecal.io.formats._poses import pose, rig_of
from stereorecal.io.formats.text._nodes import Keys, Values

NAME = "stereorecal"
KEYS = ("image_size", "K_left", "D_left", "K_right", "D_right", "distortion_model", "R", "T", "baseline_m")
_SIDES = ("left", "right")


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; a camera is one without distortion where its coefficients are null."""
    content, cameras = documents[0].content, []
    if all(value(content, f"K_{side}") is None for side in _SIDES):
        raise InputError("the camera matrices are null; give a file with a calibration.")
    model, size = model_named(optional(content, "distortion_model")), image_size(content, "image_size")
    for side in _SIDES:
        matrix, key = numbers(content, f"K_{side}", (3, 3)), f"D_{side}"
        distortion = np.zeros(0) if value(content, key) is None else numbers(content, key, (-1,))
        with about(f"{side} camera"):
            cameras.append(Camera(size, matrix, distortion, model=model))
    left, right = cameras
    return rig_of(left, right, pose(numbers(content, "R", (3, 3)), numbers(content, "T", (3,))))


def _write(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> list[Values]:
    """R, T and the baseline, and the intrinsics of cameras that have changed; a changed rig is no ground truth."""
    content = documents[0].content
    keep = {f"{key}_{side}" for number, side in enumerate(_SIDES) if number not in changed for key in ("K", "D")}
    keep |= {"image_size", "distortion_model"} & content.keys()
    values: dict[Keys, Any] = {(key,): item for key, item in calibration_of(rig).items() if key not in keep}
    return [values | {("reference",): "stored"} if "reference" in content else values]


def calibration_text(content: Mapping[str, Any]) -> str:
    """The text of a calib.json. Unlike a report, a calibration is refused rather than written with null for NaN."""
    try:
        return strict_json_text(content)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"info cannot be written as JSON ({error}); use plain finite values.") from error


def calibration_of(rig: StereoRig) -> dict[str, Any]:
    """What a calib.json has under `KEYS` for a rig."""
    if rig.left.model != rig.right.model:
        raise InputError(
            f"the lenses are of the models {rig.left.model!r} and {rig.right.model!r}, but a calib.json has one for "
            "both; write the rig as kalibr or basalt instead."
        )
    found: dict[str, Any] = {"image_size": list(rig.left.size)}
    for side, camera in zip(_SIDES, (rig.left, rig.right), strict=True):
        found |= {f"K_{side}": np.asarray(camera.matrix).tolist(), f"D_{side}": np.asarray(camera.distortion).tolist()}
    return found | {
        "distortion_model": "opencv" if rig.left.model == Camera.model else rig.left.model,
        "R": np.asarray(rig.rotation).tolist(),
        "T": np.asarray(rig.translation).tolist(),
        "baseline_m": float(rig.baseline),
    }


FORMAT = Format(
    NAME,
    "calib.json of a scene folder (K_left, D_left, K_right, D_right, R, T in metres)",
    "m",
    lambda document: document.syntax is Syntax.JSON and bool({"K_left", "K_right"} & document.content.keys()),
    _read,
    one_size=True,
    syntax=JSON,
    blank=lambda rig, syntax: (calibration_text(calibration_of(rig)),),
    write=_write,
)
