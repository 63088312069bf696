"""calib.json: the calibration of a scene folder, and the format in which this library writes a rig."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io._json import read_json, strict_json_text
from stereorecal.io.formats._numbers import image_size, numbers, value

# Names of OpenCV's pinhole model: its own, those of ROS (plumb_bob, rational_polynomial) and of Kalibr (radtan).
_PINHOLE_MODELS = frozenset({"", "none", "opencv", "plumb_bob", "rational_polynomial", "radtan"})
_FISHEYE_WORDS = ("fisheye", "equi", "omni")


@dataclass(frozen=True, eq=False)
class Calibration:
    """The content of a calib.json.

    Attributes:
        size: (width, height) of the images in pixels.
        rig: None if both camera matrices are null.
        reference: "truth" if the rig is known to be exact, such as that of a rendered scene, else "stored".
        info: the keys that do not describe the rig, unchanged.
    """

    size: tuple[int, int]
    rig: StereoRig | None
    reference: str
    info: Mapping[str, Any]


def load_calibration(path: Path) -> Calibration:
    """The calibration in a calib.json.

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's pinhole model.
    """
    content = read_json_object(path)
    with about(path):
        size, rig = image_size(content, "image_size"), rig_from(content)
    known = {*calibration_of(None, size), "reference"}
    info = {key: item for key, item in content.items() if key not in known}
    return Calibration(size, rig, "truth" if content.get("reference") == "truth" else "stored", info)


def calibration_text(content: Mapping[str, Any]) -> str:
    """The text of a calib.json. Unlike a report, a calibration is refused rather than written with null for NaN.

    Raises:
        InputError: if JSON cannot hold a value.
    """
    try:
        return strict_json_text(content)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"info cannot be written as JSON ({error}); use plain finite values.") from error


def read_json_object(path: Path) -> dict[str, Any]:
    """The keys and values of a JSON file beside the images, such as calib.json.

    Raises:
        InputError: naming the file, if it is missing, empty, truncated, not a JSON object, or contains a number that
            is not finite.
    """
    content = read_json(path, if_missing="check the path, or write a calib.json there.")
    if not isinstance(content, dict):
        raise InputError(f"{path}: there is no JSON object of named values in the file; correct it.")
    return content


def rig_from(content: Mapping[str, Any]) -> StereoRig | None:
    """The rig that a calib.json describes; None if both camera matrices are null.

    Raises:
        InputError: if a key is missing, or the values are not a valid calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's pinhole model.
    """
    if all(value(content, key) is None for key in ("K_left", "K_right")):
        return None
    _check_model(content.get("distortion_model"))
    size = image_size(content, "image_size")
    left, right = (_camera(content, side, size) for side in ("left", "right"))
    return StereoRig.from_rotation(left, right, numbers(content, "R", (3, 3)), numbers(content, "T", (3,)))


def calibration_of(rig: StereoRig | None, size: tuple[int, int]) -> dict[str, Any]:
    """The inverse of `rig_from`: the keys of a calib.json for a rig; all null but `image_size` if `rig` is None."""
    if rig is None:
        nothing = dict.fromkeys(("K_left", "D_left", "K_right", "D_right", "distortion_model", "R", "T", "baseline_m"))
        return {"image_size": list(size), **nothing}
    return {
        "image_size": list(rig.left.size),
        "K_left": np.asarray(rig.left.matrix).tolist(),
        "D_left": np.asarray(rig.left.distortion).tolist(),
        "K_right": np.asarray(rig.right.matrix).tolist(),
        "D_right": np.asarray(rig.right.distortion).tolist(),
        "distortion_model": "opencv",
        "R": np.asarray(rig.rotation).tolist(),
        "T": np.asarray(rig.translation).tolist(),
        "baseline_m": float(rig.baseline),
    }


def _check_model(model: Any) -> None:
    name = str(model or "").lower()
    base = re.split(r"[(;,]", name)[0].strip()
    if not (base in _PINHOLE_MODELS or base.startswith("opencv")) or any(word in name for word in _FISHEYE_WORDS):
        raise UnsupportedModelError(
            f"the distortion model {model!r} is not supported; "
            "calibrate with OpenCV's pinhole model (plumb_bob or rational_polynomial)."
        )


def _camera(content: Mapping[str, Any], side: str, size: tuple[int, int]) -> Camera:
    matrix, distortion = numbers(content, f"K_{side}", (3, 3)), _distortion(content, f"D_{side}")
    with about(f"{side} camera"):
        return Camera(size, matrix, distortion)


def _distortion(content: Mapping[str, Any], key: str) -> Float[np.ndarray, "n"]:
    """The distortion coefficients; none if the value is null."""
    return np.zeros(0) if value(content, key) is None else numbers(content, key, (-1,))
