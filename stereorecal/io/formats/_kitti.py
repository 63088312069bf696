"""KITTI's calibrations: calib_cam_to_cam.txt of raw data, four cameras as they are (S K D R T) and as KITTI rectified
their images; and calib.txt of odometry and stereo 2012, the projection matrices `P = K [I | t]` of rectified images."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import COLONS, Documents, Format, Hints, Syntax, Target
from stereorecal.io.formats._lens_numbers import check_straight, coefficients
from stereorecal.io.formats._numbers import image_size, numbers
from stereorecal.io.formats._rectification_matrices import RectifyOptions, rectification_of
from stereorecal.io.formats._rigid_motions import Pose, inverse, left_to_right, pose, rig_of
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import Keys, Values

_CHOICES = (("00", "01"), ("02", "03"))  # grey before colour
_COUNTS = {"S": 2, "K": 9, "D": 5, "R": 9, "T": 3, "S_rect": 2, "R_rect": 9, "P_rect": 12}
_RECTIFY = RectifyOptions(alpha=0.0)
_GREY = ("P0", "P1")
_OF_RECTIFIED = ("P0", "P1", "P2", "P3")


def in_projection(projection: Float[np.ndarray, "3 4"], size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The rectified camera K of P = K [I | t], and t."""
    camera = Camera(size, projection[:, :3])
    return camera, np.linalg.solve(camera.matrix, projection[:, 3])


def _camera_and_place(content: Mapping[str, Any], key: str, size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The camera of P, and the position t of camera 00 in its frame."""
    projection = numbers(content, key, (12,)).reshape(3, 4)
    with about(key):
        return in_projection(projection, size)


def _rectified_rig(content: Mapping[str, Any], keys: tuple[str, str], size: tuple[int, int]) -> StereoRig:
    """The rig of two cameras: all have the same orientation, and P places each of them.

    Between the colour cameras t differs slightly in y and z too: the four cameras are not exactly on one line.
    """
    (left, from_left), (right, from_right) = (_camera_and_place(content, key, size) for key in keys)
    return rig_of(left, right, pose(np.eye(3), from_right - from_left))


# --- calib.txt of odometry


def _read_odometry(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of the grey cameras P0 and P1, unless the hints name others; the file has no image size."""
    size = hints.needed_size("the file has no image size")
    return _rectified_rig(documents[0].content, hints.cameras or _GREY, size)


def _write_odometry(rig: StereoRig, target: Target) -> list[Values]:
    """The projection matrix of the right camera changes."""
    check_straight(rig, "KITTI's calib.txt")
    content, keys = target.documents[0].content, target.hints.cameras or _GREY
    fresh = target.left and target.right and not any(np.any(content[key]) for key in keys)
    place = np.zeros(3) if fresh else _camera_and_place(content, keys[0], rig.left.size)[1]
    sides = [(keys[1], rig.right, place + np.asarray(rig.translation))]
    sides += [(keys[0], rig.left, place)] if target.left else []
    return [
        {
            (key,): np.column_stack([camera.matrix, np.asarray(camera.matrix) @ shift]).ravel().tolist()
            for key, camera, shift in sides
        }
    ]


ODOMETRY = Format(
    "kitti-odometry",
    "KITTI odometry's calib.txt (P0, P1, P2, P3) of rectified images",
    "m",
    lambda document: document.syntax is Syntax.COLONS and bool(document.content.keys() & {*_OF_RECTIFIED}),
    _read_odometry,
    cameras=lambda documents: _OF_RECTIFIED,
    syntax=COLONS,
    blank=lambda rig, syntax: (f"P0: {'0 ' * 11}0\nP1: {'0 ' * 11}0\n",),
    write=_write_odometry,
)


# --- calib_cam_to_cam.txt of raw data


def _looks_raw(document: Document) -> bool:
    """Whether there are lines of a camera that is numbered with two digits."""
    return any(f"{key}_{pair[0]}" in document.content for key in ("K", "P_rect") for pair in _CHOICES)


def _cameras(documents: Documents) -> tuple[str, ...]:
    """The cameras that there are, those first that are read by default."""
    pairs = sorted(_CHOICES, key=lambda pair: f"K_{pair[0]}" not in documents[0].content)
    return tuple(name for pair in pairs for name in pair)


def _read_raw(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of the cameras as they are; or as rectified, if the images have the size of the rectified ones alone."""
    content, cameras = documents[0].content, _chosen(documents, hints)
    if _is_rectified(content, cameras, hints):
        keys = f"P_rect_{cameras[0]}", f"P_rect_{cameras[1]}"
        return _rectified_rig(content, keys, image_size(content, f"S_rect_{cameras[0]}"))
    left, right = (_camera(content, name) for name in cameras)
    to_left, to_right = (_from_first(content, name) for name in cameras)
    return rig_of(left, right, to_right @ inverse(to_left))


def _blank_raw(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """The grey cameras, raw and rectified."""
    lines = [f"{key}_{name}: {'0 ' * (count - 1)}0\n" for name in _CHOICES[0] for key, count in _COUNTS.items()]
    return ("".join(lines),)


def _write_raw(rig: StereoRig, target: Target) -> list[Values]:
    """R and T of the right camera; R_rect and P_rect (alpha 0) of both, where the file has those of no other camera."""
    content, cameras = target.documents[0].content, _chosen(target.documents, target.hints)
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
    fresh = not any(np.any(content[f"K_{name}"]) for name in cameras)
    to_left = np.eye(4) if fresh else _from_first(content, cameras[0])
    values: dict[Keys, list[float]] = {}
    if fresh:
        values |= _arrays(cameras[0], {"R": np.eye(3), "T": np.zeros(3)})
        for name, camera in zip(cameras, (rig.left, rig.right), strict=True):
            values |= _arrays(name, {"S": np.array(camera.size, float), "S_rect": np.array(camera.size, float)})
    to_right = left_to_right(rig) @ to_left
    values |= _arrays(cameras[1], {"R": to_right[:3, :3], "T": to_right[:3, 3]})
    for side, camera in target.cameras(rig):
        lens = coefficients(camera, (5,), "KITTI's calibration", "opencv, ros or depthai")
        values |= _arrays(cameras[side], {"K": np.asarray(camera.matrix), "D": lens})
    made = rectification_of(rig, _RECTIFY)
    for side, name in enumerate(cameras, start=1):
        values |= _arrays(name, {"R_rect": made[f"R{side}"], "P_rect": made[f"P{side}"]})
    return [{keys: value for keys, value in values.items() if keys[0] in content}]


def _arrays(name: str, arrays: Mapping[str, np.ndarray]) -> dict[Keys, list[float]]:
    return {(f"{key}_{name}",): array.ravel().tolist() for key, array in arrays.items()}


def _chosen(documents: Documents, hints: Hints) -> tuple[str, str]:
    """The pair that the hints name, else the first of which there is one."""
    left, right = hints.cameras or _cameras(documents)[:2]
    return left, right


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


RAW = Format(
    "kitti-raw",
    "KITTI raw data's calib_cam_to_cam.txt (S_00, K_00, D_00, R_00, T_00 …)",
    "m",
    _looks_raw,
    _read_raw,
    cameras=_cameras,
    syntax=COLONS,
    blank=_blank_raw,
    write=_write_raw,
)
