"""BoofCV's stereo YAML: two cameras, and the pose that takes points from the right one to the left one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._lens_numbers import check_model, coefficients, pinhole_matrix, pinhole_numbers
from stereorecal.io.formats._matrix_values import matrix_values
from stereorecal.io.formats._numbers import numbers, pixels, value
from stereorecal.io.formats._rigid_motions import inverse, left_to_right, pose, rig_of
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys, at, leaves

NAME = "boofcv"
ABOUT = "BoofCV's stereo calibration (YAML with left, right, rightToLeft)"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}
FILES = 1
UNIT = None

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


def can_read(documents: Documents) -> bool:
    """Whether there is a pose from right to left."""
    return len(documents) == 1 and isinstance(documents[0].content.get("rightToLeft"), Mapping)


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a BoofCV file, whose pose, from right to left, is inverted."""
    content = documents[0].content
    left, right = (_camera(content, side) for side in ("left", "right"))
    with about("rightToLeft"):
        stated = content["rightToLeft"]
        rotation = numbers({"rotation": list(leaves(value(stated, "rotation")))}, "rotation", (9,))
        shift = np.array([float(numbers(stated, key, ())) for key in "xyz"])
        return rig_of(left, right, inverse(pose(rotation.reshape(3, 3), shift)))


def _camera(content: Mapping[str, Any], side: str) -> Camera:
    with about(side):
        camera = value(content, side)
        if not isinstance(camera, Mapping):
            raise InputError("there is no camera; copy the file again.")
        check_model(camera.get("model", _PINHOLE), (_PINHOLE,))
        stated, lens = value(camera, "pinhole"), value(camera, "radial_tangential")
        if float(numbers(stated, "skew", ())) != 0.0:
            raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
        matrix = pinhole_matrix(np.array([float(numbers(stated, key, ())) for key in _NUMBERS]))
        radial = numbers(lens, "radial", (-1,)) if lens.get("radial") else np.zeros(0)
        if radial.size > 3:
            raise InputError(f"radial has {radial.size} terms, and OpenCV's model three; calibrate with fewer.")
        k1, k2, k3 = np.concatenate([radial, np.zeros(3 - radial.size)])
        t1, t2 = (float(numbers(lens, key, ())) for key in ("t1", "t2"))
        distortion = np.array([k1, k2, t1, t2, k3][: 5 if radial.size == 3 else 4])
        return Camera((pixels(stated, "width"), pixels(stated, "height")), matrix, distortion)


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """One file, its keys in BoofCV's order."""
    left, right = (
        _CAMERA.format(side=side, width=camera.size[0], height=camera.size[1])
        for side, camera in (("left", rig.left), ("right", rig.right))
    )
    return (f"# Intrinsic and extrinsic parameters for a stereo camera pair\n{left}{_POSE}{right}",)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A BoofCV file: rightToLeft, and the intrinsics of the cameras of the target."""
    (document,) = target.documents
    back = inverse(left_to_right(rig))
    values: dict[Keys, Any] = matrix_values(document.content, ("rightToLeft", "rotation"), back[:3, :3])
    values |= {("rightToLeft", key): float(number) for key, number in zip("xyz", back[:3, 3], strict=True)}
    for side, camera, wanted in (("left", rig.left, target.left), ("right", rig.right, target.right)):
        if wanted:
            values.update(_camera_values(camera, side, document.content))
    return (document.with_values(values),)


def _camera_values(camera: Camera, side: str, content: Mapping[str, Any]) -> dict[Keys, Any]:
    k1, k2, t1, t2, k3 = coefficients(camera, (5,), "BoofCV's model", "opencv, ros or depthai").tolist()
    stated = at(content, (side, "radial_tangential", "radial")) or []
    if not stated and any((k1, k2, k3)):
        raise InputError(f"{side}: the file has no radial terms; add `radial: [0.0, 0.0]` to write new ones.")
    needed = 3 if k3 else 2 if k2 else 1 if k1 else 0
    lens = {"radial": [k1, k2, k3][: max(len(stated), needed)], "t1": t1, "t2": t2}
    values: dict[Keys, Any] = {(side, "radial_tangential", key): number for key, number in lens.items() if number != []}
    pinhole = zip(_NUMBERS, pinhole_numbers(camera), strict=True)
    return values | {(side, "pinhole", key): number for key, number in pinhole}
