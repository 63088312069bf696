"""The numbers of a lens (camera matrix, distortion) as formats hold them, and the words for its model."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig

ROUNDING = 1e-9  # radians; and parts of the baseline
_WAY_OUT = "undistort the images, or calibrate as pinhole with radial-tangential distortion, or as equidistant"
# Formats that have a place for a lens model, for messages.
_HOLDERS = {
    "radtan": "opencv, ros or depthai",
    "equidistant": "kalibr, ros or stereorecal",
    "ds": "kalibr, basalt or stereorecal",
    "eucm": "kalibr, basalt or stereorecal",
    "omni": "kalibr or stereorecal",
}

# Names of OpenCV's pinhole model: its own, those of ROS (plumb_bob, rational_polynomial) and of Kalibr (radtan).
_PINHOLE = frozenset({"", "none", "opencv", "plumb_bob", "rational_polynomial", "radtan"})
_FISHEYE = ("fisheye", "equidistant", "kannala", "kb4")  # anywhere in it
_OTHER = ("equi", "omni")


def pinhole_matrix(numbers: Float[np.ndarray, "4"]) -> Mat3:
    """The camera matrix of fx, fy, cx, cy."""
    fx, fy, cx, cy = numbers
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def pinhole_numbers(camera: Camera) -> list[float]:
    """fx, fy, cx, cy."""
    matrix = np.asarray(camera.matrix)
    return [float(matrix[place]) for place in ((0, 0), (1, 1), (0, 2), (1, 2))]


def check_held(camera: Camera, models: Sequence[str], what: str) -> None:
    """Refuse a lens of a model that a format has no place for.

    Args:
        models: that it holds.
        what: for the message: whose lens models these are.
    """
    if camera.model not in models:
        raise InputError(
            f"{what} has no place for a lens of the model {camera.model!r}; write it as {_HOLDERS[camera.model]} "
            "instead."
        )


def has_lens(rig: StereoRig) -> bool:
    """Whether a camera is anything but a pinhole without distortion."""
    return any(camera.model != "radtan" or bool(np.any(camera.distortion)) for camera in (rig.left, rig.right))


def coefficients(camera: Camera, counts: Sequence[int], what: str, instead: str) -> Float[np.ndarray, "n"]:
    """The radial-tangential distortion in OpenCV's order, with as many coefficients as a file takes: the first count
    that is enough.

    Args:
        counts: that are possible, rising.
        what, instead: for the message: whose lens model is too small, and the formats that hold more.
    """
    check_held(camera, ("radtan",), what or "this file")
    own = np.asarray(camera.distortion, float)
    needed = int(np.max(np.flatnonzero(own), initial=-1)) + 1
    for count in counts:
        if count >= needed:
            return np.concatenate([own, np.zeros(max(0, count - own.size))])[:count]
    if not counts:
        raise InputError(f"the file has more lens coefficients than {what} knows; calibrate with fewer.")
    raise InputError(
        f"{what} has {counts[-1]} lens coefficients, and this rig needs {needed}; write it as {instead} instead."
    )


def trimmed(distortion: Float[np.ndarray, "n"]) -> Float[np.ndarray, "m"]:
    """The distortion without those rational, prism and tilt terms that are all zero: the same lens, and the same digits
    of what is computed from it, as from a format that has no place for them."""
    return next((distortion[:count] for count in (5, 8, 12) if not np.any(distortion[count:])), distortion)


def check_model(
    model: object, known: Sequence[str], camera: object = "pinhole", cameras: Sequence[str] = ("pinhole",)
) -> None:
    """Refuse a camera model, or a distortion model of it, that is not one of those known."""
    if camera not in cameras or model not in known:
        raise UnsupportedModelError(
            f"the camera model {camera!r} with the distortion model {model!r} is not supported; {_WAY_OUT}."
        )


def check_no_lens(model: object, lens: Float[np.ndarray, "n"]) -> None:
    """Refuse coefficients of a lens that is said to have none."""
    if model in ("", "none") and np.any(lens):
        raise InputError(
            f"the distortion model is {model!r}, but there are coefficients; name their model (plumb_bob, radtan), or "
            "set them to zero."
        )


def check_straight(rig: StereoRig, what: str, off_line: object = False) -> None:
    """Refuse a rotation of more than rounding, or a lens, in a format of rectified images.

    Args:
        off_line: whether there is anything else that such a format has no place for.
    """
    turned = np.abs(np.asarray(rig.extrinsics)[:3]).max() > ROUNDING
    if turned or off_line or has_lens(rig):
        raise InputError(
            f"{what} has no place for a rotation or a lens; write it as opencv, kalibr or stereorecal instead."
        )


def model_named(stated: Any) -> str:
    """The model of `Camera` that a word means, which a remark may follow; that of OpenCV's pinhole for None."""
    name = str(stated or "").lower()
    base = re.split(r"[(;,]", name)[0].strip()
    if any(word in name for word in _FISHEYE):
        return "equidistant"
    if base in ("ds", "eucm", "omni"):
        return base
    if not (base in _PINHOLE or base.startswith("opencv")) or any(word in name for word in _OTHER):
        raise UnsupportedModelError(
            f"the distortion model {stated!r} is not supported; undistort the images, or calibrate with OpenCV's "
            "pinhole model (plumb_bob or rational_polynomial) or its fisheye (equidistant)."
        )
    return Camera.model


def model_word(rig: StereoRig) -> str:
    """The word for both lenses."""
    if rig.left.model != rig.right.model:
        raise InputError(
            f"the lenses are of the models {rig.left.model!r} and {rig.right.model!r}, but a calib.json has one for "
            "both; write the rig as kalibr or basalt instead."
        )
    return "opencv" if rig.left.model == Camera.model else rig.left.model
