"""The calibration inside a scene folder's calib.json."""

import json
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
from stereorecal.io.formats._text import read_text

# Names of OpenCV's pinhole model: its own, ROS's, Kalibr's.
_PINHOLE_MODELS = frozenset({"", "none", "opencv", "plumb_bob", "rational_polynomial", "radtan"})
_FISHEYE_WORDS = ("fisheye", "equi", "omni")


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calib.json says.

    Attributes:
        size: (width, height) of the images in pixels.
        rig: None if both camera matrices are null.
        reference: what the rig is worth: "truth" or "stored".
        info: the keys that say nothing about the rig, as they stand.
    """

    size: tuple[int, int]
    rig: StereoRig | None
    reference: str
    info: Mapping[str, Any]


def load_calibration(path: Path) -> Calibration:
    """The calibration in a calib.json.

    Raises:
        InputError: naming the file, if it cannot be read, or a value cannot be a calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's.
    """
    content = read_calibration(path)
    with about(path):
        size, rig = image_size(content), rig_from(content)
    known = {*calibration_of(None, size), "reference"}
    info = {key: value for key, value in content.items() if key not in known}
    return Calibration(size, rig, "truth" if content.get("reference") == "truth" else "stored", info)


def calibration_text(content: Mapping[str, Any]) -> str:
    """The text of a calib.json.

    Raises:
        InputError: if a value is none that JSON has.
    """
    try:
        return json.dumps(content, indent=1, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"the scene's info cannot be written as JSON ({error}); use plain finite values.") from error


def read_calibration(path: Path) -> dict[str, Any]:
    """The content of a calib.json.

    Raises:
        InputError: if the file is missing, empty, truncated, no JSON object, or contains NaN.
    """
    text = read_text(path, if_missing="a scene folder needs a calib.json.")
    try:
        with about(path):
            content = json.loads(text, parse_constant=_refuse_constant)
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON, or truncated ({error}); correct or copy it again.") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: the content is no JSON object of named values; correct it.")
    return content


def _refuse_constant(token: str) -> None:
    raise InputError(f"the file contains {token}; put a finite number, or null where none is known.")


def image_size(content: Mapping[str, Any]) -> tuple[int, int]:
    """(width, height) in pixels.

    Raises:
        InputError: if it is missing or not two positive whole numbers.
    """
    size = _numbers(content, "image_size", (2,))
    if size.min() < 1 or np.any(size != np.rint(size)):
        raise InputError(f"image_size {content['image_size']} is not [width, height] in pixels; correct it.")
    return int(size[0]), int(size[1])


def rig_from(content: Mapping[str, Any]) -> StereoRig | None:
    """The rig that a calib.json describes; None if both camera matrices are null.

    Raises:
        InputError: if a key is missing or a value cannot be a calibration.
        UnsupportedModelError: if the distortion model is not OpenCV's.
    """
    if all(_value(content, key) is None for key in ("K_left", "K_right")):
        return None
    _check_model(content.get("distortion_model"))
    size = image_size(content)
    left, right = (_camera(content, side, size) for side in ("left", "right"))
    return StereoRig.from_rotation(left, right, _numbers(content, "R", (3, 3)), _numbers(content, "T", (3,)))


def calibration_of(rig: StereoRig | None, size: tuple[int, int]) -> dict[str, Any]:
    """The inverse of `rig_from`: what calib.json says of a rig (None: all null) with images of `size`."""
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
    matrix, distortion = _numbers(content, f"K_{side}", (3, 3)), _distortion(content, f"D_{side}")
    with about(f"{side} camera"):
        return Camera(size, matrix, distortion)


def _distortion(content: Mapping[str, Any], key: str) -> Float[np.ndarray, "n"]:
    if _value(content, key) in (None, []):
        return np.zeros(0)
    coefficients = _numbers(content, key)
    if coefficients.ndim > 1:
        raise InputError(
            f"{key} must be a list of coefficients, not an array of shape {coefficients.shape}; correct it."
        )
    return coefficients.reshape(-1)


def _numbers(content: Mapping[str, Any], key: str, shape: tuple[int, ...] | None = None) -> Float[np.ndarray, "..."]:
    """A finite float64 array of the given shape (rows and columns of one are dropped)."""
    value = _value(content, key)
    try:
        array = np.array(value, float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{key} is not an array of numbers; correct it.") from None
    if value is None or not np.isfinite(array).all():
        raise InputError(f"{key} contains null, NaN or infinite numbers; correct it.")
    if shape is not None and array.squeeze().shape != shape:
        expected = "x".join(map(str, shape))
        raise InputError(f"{key} must be {expected} numbers, not an array of shape {array.shape}; correct it.")
    return array.squeeze()


def _value(content: Mapping[str, Any], key: str) -> Any:
    if key not in content:
        raise InputError(f"the key {key!r} is missing; add it.")
    return content[key]
