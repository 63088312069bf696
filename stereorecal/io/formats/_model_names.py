"""The words for a lens model in files that are written by people and by many programs."""

import re
from typing import Any

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig

# Names of OpenCV's pinhole model: its own, those of ROS (plumb_bob, rational_polynomial) and of Kalibr (radtan).
_PINHOLE = frozenset({"", "none", "opencv", "plumb_bob", "rational_polynomial", "radtan"})
_FISHEYE = ("fisheye", "equidistant", "kannala", "kb4")  # anywhere in it
_OTHER = ("equi", "omni")


def model_named(stated: Any) -> str:
    """The model of `Camera` that a word means, which a remark may follow; that of OpenCV's pinhole for None.

    Raises:
        UnsupportedModelError: if there is none.
    """
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
    """The word for both lenses.

    Raises:
        InputError: if they are of different models.
    """
    if rig.left.model != rig.right.model:
        raise InputError(
            f"the lenses are of the models {rig.left.model!r} and {rig.right.model!r}, but a calib.json has one for "
            "both; write the rig as kalibr or basalt instead."
        )
    return "opencv" if rig.left.model == Camera.model else rig.left.model
