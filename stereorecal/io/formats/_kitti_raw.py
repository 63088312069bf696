"""KITTI's calib_cam_to_cam.txt: four cameras, as they are (S K D R T) and as KITTI rectified their images."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._kitti_rectified import rectified_rig
from stereorecal.io.formats._lens_numbers import coefficients
from stereorecal.io.formats._numbers import image_size, numbers
from stereorecal.io.formats._rectification_matrices import RectifyOptions, rectification_of
from stereorecal.io.formats._rigid_motions import Pose, inverse, left_to_right, pose, rig_of
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "kitti-raw"
ABOUT = "KITTI raw data's calib_cam_to_cam.txt (S_00, K_00, D_00, R_00, T_00 …)"
SYNTAX = {".txt": Syntax.COLONS}
FILES = 1
UNIT = "m"

_CHOICES = (("00", "01"), ("02", "03"))  # grey before colour
_COUNTS = {"S": 2, "K": 9, "D": 5, "R": 9, "T": 3, "S_rect": 2, "R_rect": 9, "P_rect": 12}
_RECTIFY = RectifyOptions(alpha=0.0)


def can_read(documents: Documents) -> bool:
    """Whether there are lines of a camera that is numbered with two digits."""
    content = documents[0].content
    return len(documents) == 1 and any(f"{key}_{pair[0]}" in content for key in ("K", "P_rect") for pair in _CHOICES)


def cameras(documents: Documents) -> tuple[str, ...]:
    """The cameras that there are, those first that are read by default."""
    pairs = sorted(_CHOICES, key=lambda pair: f"K_{pair[0]}" not in documents[0].content)
    return tuple(name for pair in pairs for name in pair)


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a KITTI raw calibration: the cameras as they are; or, if the images have the size of the rectified
    ones and not of these, as rectified."""
    content, cameras = documents[0].content, _cameras(documents, hints)
    if _is_rectified(content, cameras, hints):
        return rectified_rig(content, _keys("P_rect", cameras), image_size(content, f"S_rect_{cameras[0]}"))
    left, right = (_camera(content, name) for name in cameras)
    to_left, to_right = (_from_first(content, name) for name in cameras)
    return rig_of(left, right, to_right @ inverse(to_left))


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """The grey cameras, raw and rectified."""
    lines = [f"{key}_{name}: {'0 ' * (count - 1)}0\n" for name in _CHOICES[0] for key, count in _COUNTS.items()]
    return ("".join(lines),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A KITTI raw calibration: R and T of the right camera; R_rect and P_rect (alpha 0) of both, where the file has
    those of no other camera."""
    (document,), cameras = target.documents, _cameras(target.documents, target.hints)
    content = document.content
    if _is_rectified(content, cameras, target.hints):
        raise InputError(
            "the rig is that of KITTI's rectified images, and the file has no place for a rotation between those; "
            "write it as opencv, kalibr or stereorecal instead."
        )
    rectified = {key.rpartition("_")[2] for key in content if key.startswith(("R_rect_", "P_rect_"))}
    if rectified - set(cameras):
        raise InputError(
            "the file has one rectification of four cameras, which would not fit the new rig; write it as opencv, "
            "kalibr or stereorecal instead."
        )
    fresh = not any(np.any(content[key]) for key in _keys("K", cameras))
    to_left = np.eye(4) if fresh else _from_first(content, cameras[0])
    values: dict[Keys, list[float]] = {}
    if fresh:
        values |= _arrays(cameras[0], {"R": np.eye(3), "T": np.zeros(3)})
        for name, camera in zip(cameras, (rig.left, rig.right), strict=True):
            values |= _arrays(name, {"S": np.array(camera.size, float), "S_rect": np.array(camera.size, float)})
    to_right = left_to_right(rig) @ to_left
    values |= _arrays(cameras[1], {"R": to_right[:3, :3], "T": to_right[:3, 3]})
    made = rectification_of(rig, _RECTIFY)
    for side, (name, camera) in enumerate(zip(cameras, (rig.left, rig.right), strict=True), start=1):
        if (target.left, target.right)[side - 1]:
            lens = coefficients(camera, (5,), "KITTI's calibration", "opencv, ros or depthai")
            values |= _arrays(name, {"K": np.asarray(camera.matrix), "D": lens})
        values |= _arrays(name, {"R_rect": made[f"R{side}"], "P_rect": made[f"P{side}"]})
    return (document.with_values({keys: value for keys, value in values.items() if keys[0] in content}),)


def _arrays(name: str, arrays: Mapping[str, np.ndarray]) -> dict[Keys, list[float]]:
    return {(f"{key}_{name}",): array.ravel().tolist() for key, array in arrays.items()}


def _keys(key: str, cameras: tuple[str, str]) -> tuple[str, str]:
    return f"{key}_{cameras[0]}", f"{key}_{cameras[1]}"


def _cameras(documents: Documents, hints: Hints) -> tuple[str, str]:
    """The pair that the hints name, else the first of which there is one."""
    content = documents[0].content
    return hints.cameras or next((pair for pair in _CHOICES if f"K_{pair[0]}" in content), _CHOICES[0])


def _is_rectified(content: Mapping[str, Any], cameras: tuple[str, str], hints: Hints) -> bool:
    """Whether the images are KITTI's rectified ones: by the hints, else by their size."""
    if hints.rectified is not None:
        return hints.rectified
    keys = f"S_rect_{cameras[0]}", f"S_{cameras[0]}"
    if hints.size is None or not all(key in content for key in keys):
        return False
    rectified, raw = (image_size(content, key) for key in keys)
    return hints.size == rectified != raw


def _camera(content: Mapping[str, Any], name: str) -> Camera:
    with about(f"camera {name}"):
        matrix = numbers(content, f"K_{name}", (9,)).reshape(3, 3)
        return Camera(image_size(content, f"S_{name}"), matrix, numbers(content, f"D_{name}", (-1,)))


def _from_first(content: Mapping[str, Any], name: str) -> Pose:
    """The pose that takes points of camera 00 to this camera."""
    return pose(numbers(content, f"R_{name}", (9,)).reshape(3, 3), numbers(content, f"T_{name}", (3,)))
