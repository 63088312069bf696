"""BoofCV's stereo YAML: two cameras, and the pose that takes points from the right one to the left one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Documents, Format, Hints, Syntax, Target
from stereorecal.io.formats._lens_numbers import check_model, coefficients, pinhole_matrix, pinhole_numbers
from stereorecal.io.formats._matrix_values import matrix_values
from stereorecal.io.formats._numbers import numbers, pixels, scalars, value
from stereorecal.io.formats._rigid_motions import inverse, left_to_right, pose, rig_of
from stereorecal.io.formats.text._nodes import Keys, Values, at, leaves, under

_SIDES = ("left", "right")
_PINHOLE, _NUMBERS = "pinhole_radial_tangential", ("fx", "fy", "cx", "cy")
_CAMERA = """\
{side}:
  pinhole:
    fx: 0.0
    fy: 0.0
    cx: 0.0
    cy: 0.0
    width: {width}
    height: {height}
    skew: 0.0
  model: pinhole_radial_tangential
  radial_tangential:
    radial:
    - 0.0
    - 0.0
    t1: 0.0
    t2: 0.0
"""
_POSE = "model: stereo_camera\nrightToLeft:\n  rotation:\n" + "  - 0.0\n" * 9 + "  x: 0.0\n  y: 0.0\n  z: 0.0\n"


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; the pose, from right to left, is inverted."""
    content = documents[0].content
    left, right = (_camera(content, side) for side in _SIDES)
    with about("rightToLeft"):
        stated = content["rightToLeft"]
        rotation = numbers({"rotation": list(leaves(value(stated, "rotation")))}, "rotation", (9,))
        return rig_of(left, right, inverse(pose(rotation.reshape(3, 3), scalars(stated, "xyz"))))


def _camera(content: Mapping[str, Any], side: str) -> Camera:
    with about(side):
        camera = value(content, side)
        if not isinstance(camera, Mapping):
            raise InputError("there is no camera; copy the file again.")
        check_model(camera.get("model", _PINHOLE), (_PINHOLE,))
        stated, lens = value(camera, "pinhole"), value(camera, "radial_tangential")
        if float(numbers(stated, "skew", ())) != 0.0:
            raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
        matrix = pinhole_matrix(scalars(stated, _NUMBERS))
        radial = numbers(lens, "radial", (-1,)) if lens.get("radial") else np.zeros(0)
        if radial.size > 3:
            raise InputError(f"radial has {radial.size} terms, and OpenCV's model three; calibrate with fewer.")
        k1, k2, k3 = np.concatenate([radial, np.zeros(3 - radial.size)])
        t1, t2 = scalars(lens, ("t1", "t2"))
        distortion = np.array([k1, k2, t1, t2, k3][: 5 if radial.size == 3 else 4])
        return Camera((pixels(stated, "width"), pixels(stated, "height")), matrix, distortion)


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """One file, its keys in BoofCV's order."""
    left, right = (
        _CAMERA.format(side=side, width=camera.size[0], height=camera.size[1])
        for side, camera in zip(_SIDES, (rig.left, rig.right), strict=True)
    )
    return (f"# Intrinsic and extrinsic parameters for a stereo camera pair\n{left}{_POSE}{right}",)


def _write(rig: StereoRig, target: Target) -> list[Values]:
    content, back = target.documents[0].content, inverse(left_to_right(rig))
    values = matrix_values(content, ("rightToLeft", "rotation"), back[:3, :3])
    values |= under(("rightToLeft",), "xyz", back[:3, 3].tolist())
    for side, camera in target.cameras(rig):
        values |= _camera_values(camera, _SIDES[side], content)
    return [values]


def _camera_values(camera: Camera, side: str, content: Mapping[str, Any]) -> dict[Keys, Any]:
    k1, k2, t1, t2, k3 = coefficients(camera, (5,), "BoofCV's model", "opencv, ros or depthai").tolist()
    stated = at(content, (side, "radial_tangential", "radial")) or []
    if not stated and any((k1, k2, k3)):
        raise InputError(f"{side}: the file has no radial terms; add `radial: [0.0, 0.0]` to write new ones.")
    needed = 3 if k3 else 2 if k2 else 1 if k1 else 0
    radial = [k1, k2, k3][: max(len(stated), needed)]
    lens = (side, "radial_tangential")
    values = under((side, "pinhole"), _NUMBERS, pinhole_numbers(camera)) | under(lens, ("t1", "t2"), (t1, t2))
    return values | ({(*lens, "radial"): radial} if radial else {})


FORMAT = Format(
    "boofcv",
    "BoofCV's stereo calibration (YAML with left, right, rightToLeft)",
    None,
    lambda document: isinstance(document.content.get("rightToLeft"), Mapping),
    _read,
    syntax=YAML,
    blank=_blank,
    write=_write,
)
