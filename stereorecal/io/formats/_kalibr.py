"""Kalibr's camchain.yaml: cam0 is the left camera, cam1 the right one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._lens_numbers import (
    check_model,
    check_no_lens,
    coefficients,
    pinhole_matrix,
    pinhole_numbers,
)
from stereorecal.io.formats._matrix_values import matrix_values
from stereorecal.io.formats._numbers import image_size, numbers, value
from stereorecal.io.formats._rigid_motions import left_to_right, rig_of
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "kalibr"
ABOUT = "Kalibr's camchain (YAML with cam0, cam1, T_cn_cnm1)"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}
FILES = 1
UNIT = "m"

_FROM_LAST, _FROM_IMU = "T_cn_cnm1", "T_cam_imu"
# Distortion models of its pinhole, and cameras of its own whose intrinsics begin with two numbers of the lens.
_DISTORTIONS = {"radtan": "radtan", "none": "radtan", "equidistant": "equidistant"}
_SPHERES, _OMNI = {"ds": "ds", "eucm": "eucm"}, "omni"  # the last one's with one, and radtan besides
_NONE = "[0.0, 0.0, 0.0, 0.0]"
_CAMERA = """\
cam{index}:
{pose}  camera_model: {kind}
  distortion_coeffs: {lens}
  distortion_model: {distortion}
  intrinsics: {numbers}
  resolution: [{width}, {height}]
"""
_POSE = "  T_cn_cnm1:\n" + "  - [0.0, 0.0, 0.0, 0.0]\n" * 3 + "  - [0.0, 0.0, 0.0, 1.0]\n"


def can_read(documents: Documents) -> bool:
    """Whether there is a cam0 or a cam1."""
    content = documents[0].content
    return len(documents) == 1 and any(isinstance(content.get(key), Mapping) for key in ("cam0", "cam1"))


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a Kalibr camchain: T_cn_cnm1 of cam1 takes points of cam0 to cam1."""
    content = documents[0].content
    for key in ("cam0", "cam1"):
        if key not in content:
            raise InputError(f"the chain has no {key}; give that of both cameras, calibrated together.")
    left, right = (_camera(content, key) for key in ("cam0", "cam1"))
    with about("cam1"):
        return rig_of(left, right, numbers(content["cam1"], _FROM_LAST, (4, 4)))


def _camera(content: Mapping[str, Any], key: str) -> Camera:
    with about(key):
        camera = content[key]
        kind, distortion = value(camera, "camera_model"), value(camera, "distortion_model")
        if kind in _SPHERES:
            check_model(distortion, ("none",), kind, tuple(_SPHERES))
            lens, pinhole = np.split(numbers(camera, "intrinsics", (6,)), [2])
            return Camera(image_size(camera, "resolution"), pinhole_matrix(pinhole), lens, model=_SPHERES[kind])
        if kind == _OMNI:
            check_model(distortion, ("radtan", "none"), kind, (_OMNI,))
            xi, pinhole = np.split(numbers(camera, "intrinsics", (5,)), [1])
            none = distortion == "none"
            lens = numbers(camera, "distortion_coeffs", (-1 if none else 4,))
            check_no_lens(distortion, lens)
            lens = np.concatenate([xi, np.zeros(4) if none else lens])
            return Camera(image_size(camera, "resolution"), pinhole_matrix(pinhole), lens, model=_OMNI)
        check_model(distortion, tuple(_DISTORTIONS), kind)
        matrix, lens = pinhole_matrix(numbers(camera, "intrinsics", (4,))), numbers(camera, "distortion_coeffs", (-1,))
        check_no_lens(distortion, lens)
        return Camera(image_size(camera, "resolution"), matrix, lens, model=_DISTORTIONS[distortion])


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """A chain of two."""
    texts = []
    for index, camera in enumerate((rig.left, rig.right)):
        kind, distortion, lens, intrinsics = "pinhole", camera.model, _NONE, _NONE
        if camera.model in _SPHERES:
            kind, distortion, lens, intrinsics = camera.model, "none", "[]", "[0.0, 0.5, 1.0, 1.0, 0.0, 0.0]"
        elif camera.model == _OMNI:
            kind, distortion, intrinsics = _OMNI, "radtan", "[0.0, 1.0, 1.0, 0.0, 0.0]"
        about_lens = {"lens": lens, "numbers": intrinsics}
        size = {"width": camera.size[0], "height": camera.size[1]}
        texts.append(
            _CAMERA.format(
                index=index, pose=_POSE if index else "", kind=kind, distortion=distortion, **about_lens, **size
            )
        )
    return ("".join(texts),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A Kalibr camchain: T_cn_cnm1 of cam1; T_cam_imu of cam1 and of what follows it in the chain, from that of
    cam0."""
    (document,) = target.documents
    content, motion = document.content, left_to_right(rig)
    values: dict[Keys, Any] = matrix_values(content, ("cam1", _FROM_LAST), motion)
    if _FROM_IMU in content["cam0"]:
        values.update(_from_imu(content, motion))
    elif any(_FROM_IMU in camera for camera in content.values() if isinstance(camera, Mapping)):
        raise InputError(f"cam1 has {_FROM_IMU} and cam0 has none; remove it, since it would not fit the new rig.")
    for key, camera, wanted in (("cam0", rig.left, target.left), ("cam1", rig.right, target.right)):
        if wanted:
            if camera.model in _SPHERES:
                values[(key, "intrinsics")] = [*np.asarray(camera.distortion).tolist(), *pinhole_numbers(camera)]
                continue
            if camera.model == _OMNI:
                xi, *distortion = np.asarray(camera.distortion).tolist()
                values[(key, "intrinsics")] = [xi, *pinhole_numbers(camera)]
                values.update(_radtan(content, key, np.array(distortion)))
                continue
            values[(key, "intrinsics")] = pinhole_numbers(camera)
            if camera.model == "equidistant":
                values.update(matrix_values(content, (key, "distortion_coeffs"), np.asarray(camera.distortion)))
                continue
            lens = coefficients(camera, (4,), "Kalibr's radtan", "opencv, ros or depthai")
            values.update(_radtan(content, key, lens))
    return (document.with_values(values),)


def _radtan(content: Mapping[str, Any], key: str, lens: np.ndarray) -> dict[Keys, Any]:
    """The distortion of a camera, which is none as long as all four coefficients are zero."""
    if content[key]["distortion_model"] != "none":
        return matrix_values(content, (key, "distortion_coeffs"), lens)
    if not np.any(lens):
        return {}
    return {(key, "distortion_model"): "radtan", **matrix_values(content, (key, "distortion_coeffs"), lens)}


def _from_imu(content: Mapping[str, Any], motion: np.ndarray) -> dict[Keys, Any]:
    values: dict[Keys, Any] = {}
    to_camera = numbers(content["cam0"], _FROM_IMU, (4, 4))
    for index in range(1, len(content)):
        camera = content.get(f"cam{index}")
        if not isinstance(camera, Mapping):
            break
        to_camera = (motion if index == 1 else numbers(camera, _FROM_LAST, (4, 4))) @ to_camera
        if _FROM_IMU in camera:
            values.update(matrix_values(content, (f"cam{index}", _FROM_IMU), to_camera))
    return values
