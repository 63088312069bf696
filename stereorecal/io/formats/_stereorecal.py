"""calib.json: the calibration of a scene folder, and the format in which this library writes a rig by default."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._matrix_roles import has_cameras
from stereorecal.io.formats._model_names import model_named, model_word
from stereorecal.io.formats._numbers import image_size, numbers, optional, value
from stereorecal.io.formats._rigid_motions import pose, rig_of
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "stereorecal"
ABOUT = "calib.json of a scene folder (K_left, D_left, K_right, D_right, R, T in metres)"
SYNTAX = {".json": Syntax.JSON}
FILES = 1
UNIT = "m"

_NO_RIG = "the camera matrices are null; give a file with a calibration."


def can_read(documents: Documents) -> bool:
    """Whether there is JSON with the matrix of a left or right camera, or with a size of images and nothing of
    OpenCV's: no R, no T, no numbered camera, and no camera matrix of another name."""
    content = documents[0].content
    named = documents[0].syntax is Syntax.JSON and bool({"K_left", "K_right"} & content.keys())
    foreign = {"R", "T"} & content.keys() or any(key.endswith(("1", "2")) for key in content)
    alone = documents[0].syntax is Syntax.JSON and "image_size" in content and not foreign
    return len(documents) == 1 and (named or (alone and not has_cameras(documents)))


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a calib.json."""
    rig = rig_from(documents[0].content)
    if rig is None:
        raise InputError(_NO_RIG)
    return rig


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """One file."""
    return (calibration_text(calibration_of(rig, rig.left.size)),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A calib.json: R, T and the baseline, and the intrinsics of the cameras of the target; a changed rig is no ground
    truth."""
    if rig.left.size != rig.right.size:
        raise InputError(
            f"the cameras have images of {_size(rig.left)} and {_size(rig.right)}, but a calib.json has one size for "
            "both; write the rig as kalibr or ros, or resize the images of one and its camera with `Camera.resized`."
        )
    (document,) = target.documents
    new = calibration_of(rig, rig.left.size)
    keep = {f"{key}_{side}" for side in ("left", "right") if not getattr(target, side) for key in ("K", "D")}
    keep |= {"image_size", "distortion_model"} & document.content.keys()
    values: dict[Keys, Any] = {(key,): item for key, item in new.items() if key not in keep}
    if "reference" in document.content:
        values[("reference",)] = "stored"
    return (document.with_values(values),)


def calibration_text(content: Mapping[str, Any]) -> str:
    """The text of a calib.json. Unlike a report, a calibration is refused rather than written with null for NaN.

    Raises:
        InputError: if JSON cannot hold a value.
    """
    try:
        return strict_json_text(content)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"info cannot be written as JSON ({error}); use plain finite values.") from error


def rig_from(content: Mapping[str, Any]) -> StereoRig | None:
    """The rig that a calib.json describes; None if both camera matrices are null.

    Raises:
        InputError: if a key is missing, or the values are not a valid calibration.
        UnsupportedModelError: if the distortion model is not known.
    """
    if all(value(content, key) is None for key in ("K_left", "K_right")):
        return None
    model, size = model_named(optional(content, "distortion_model")), image_size(content, "image_size")
    left, right = (_camera(content, side, size, model) for side in ("left", "right"))
    return rig_of(left, right, pose(numbers(content, "R", (3, 3)), numbers(content, "T", (3,))))


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
        "distortion_model": model_word(rig),
        "R": np.asarray(rig.rotation).tolist(),
        "T": np.asarray(rig.translation).tolist(),
        "baseline_m": float(rig.baseline),
    }


def _camera(content: Mapping[str, Any], side: str, size: tuple[int, int], model: str) -> Camera:
    matrix, distortion = numbers(content, f"K_{side}", (3, 3)), _distortion(content, f"D_{side}")
    with about(f"{side} camera"):
        return Camera(size, matrix, distortion, model=model)


def _distortion(content: Mapping[str, Any], key: str) -> Float[np.ndarray, "n"]:
    """The distortion coefficients; none if the value is null."""
    return np.zeros(0) if value(content, key) is None else numbers(content, key, (-1,))


def _size(camera: Camera) -> str:
    return f"{camera.size[0]}x{camera.size[1]}"
