"""KITTI's calibrations: calib_cam_to_cam.txt of raw data, four cameras as they are (S K D R T) and as KITTI rectified
their images; and calib.txt of odometry and stereo 2012, the projection matrices `P = K [I | t]` of rectified images."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stereorecal._arrays import Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import COLONS, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._numbers import check_straight, image_size, numbers
from stereorecal.io.formats._poses import pose, rig_of
from stereorecal.io.formats._rectification_matrices import RectifyOptions, rectification_of
from stereorecal.io.formats._table import Lens, Pose, Table
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import Values

_CHOICES = (("00", "01"), ("02", "03"))  # grey before colour
_TABLE = Table(
    size="S_{}",
    matrix="K_{}",
    square=True,
    lenses={"": Lens("D_{}", counts=(5,))},
    pose=Pose("R_{}", "T_{}"),  # of camera 00 in the frame of another one
    where="camera {}",
    holder="KITTI's calibration",
)
_BLANK = """\
S_{0}: {1} {2}
K_{0}: 0 0 0 0 0 0 0 0 0
D_{0}: 0 0 0 0 0
R_{0}: 1 0 0 0 1 0 0 0 1
T_{0}: 0 0 0
S_rect_{0}: {1} {2}
R_rect_{0}: 0 0 0 0 0 0 0 0 0
P_rect_{0}: 0 0 0 0 0 0 0 0 0 0 0 0
"""
_GREY = ("P0", "P1")
_OF_RECTIFIED = ("P0", "P1", "P2", "P3")


def camera_and_place(content: Mapping[str, Any], key: str, size: tuple[int, int]) -> tuple[Camera, Vec3]:
    """The rectified camera K of the P = K [I | t] under a key, and t: in KITTI's files, where camera 00 is from it."""
    projection = numbers(content, key, (3, 4))
    with about(key):
        camera = Camera(size, projection[:, :3])
        return camera, np.linalg.solve(camera.matrix, projection[:, 3])


def _rectified_rig(content: Mapping[str, Any], keys: tuple[str, str], size: tuple[int, int]) -> StereoRig:
    """The rig of two cameras of one orientation, which P places; those of colour are not exactly on one line."""
    (left, from_left), (right, from_right) = (camera_and_place(content, key, size) for key in keys)
    return rig_of(left, right, pose(np.eye(3), from_right - from_left))


# --- calib.txt of odometry


def _read_odometry(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of the grey cameras P0 and P1, unless the hints name others; the file has no image size."""
    size = hints.needed_size("the file has no image size")
    return _rectified_rig(documents[0].content, hints.cameras or _GREY, size)


def _write_odometry(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> Sequence[Values]:
    """The projection matrix of the right camera changes."""
    check_straight(rig, "KITTI's calib.txt")
    content, keys = documents[0].content, hints.cameras or _GREY
    fresh = len(changed) == 2 and not any(np.any(content[key]) for key in keys)
    place = np.zeros(3) if fresh else camera_and_place(content, keys[0], rig.left.size)[1]
    sides = [(keys[1], rig.right, place + np.asarray(rig.translation))]
    sides += [(keys[0], rig.left, place)] if 0 in changed else []
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


def _pair(document: Document) -> tuple[str, str]:
    """The cameras that are read by default: the first pair of which there is one."""
    return next((pair for pair in _CHOICES if f"K_{pair[0]}" in document.content), _CHOICES[0])


def _read_raw(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of the cameras as they are; or as rectified, if the images have the size of the rectified ones alone."""
    content, cameras = documents[0].content, hints.cameras or _pair(documents[0])
    if _is_rectified(content, cameras, hints):
        keys = f"P_rect_{cameras[0]}", f"P_rect_{cameras[1]}"
        return _rectified_rig(content, keys, image_size(content, f"S_rect_{cameras[0]}"))
    return _TABLE.read(documents, replace(hints, cameras=cameras))


def _write_raw(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> Sequence[Values]:
    """R and T of the right camera; R_rect and P_rect (alpha 0) of both, where the file has those of no other camera."""
    content, cameras = documents[0].content, hints.cameras or _pair(documents[0])
    if _is_rectified(content, cameras, hints):
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
    (values,) = _TABLE.write(rig, documents, replace(hints, cameras=cameras), changed)
    made = rectification_of(rig, RectifyOptions())
    derived = {
        (f"{key}_rect_{name}",): made[f"{key}{side}"].ravel().tolist()
        for side, name in enumerate(cameras, start=1)
        for key in "RP"
        if f"{key}_rect_{name}" in content
    }
    return [values | derived]


def _is_rectified(content: Mapping[str, Any], cameras: tuple[str, str], hints: Hints) -> bool:
    """Whether the images are KITTI's rectified ones: by the hints, else by their size."""
    if hints.rectified is not None:
        return hints.rectified
    keys = f"S_rect_{cameras[0]}", f"S_{cameras[0]}"
    if hints.size is None or not all(key in content for key in keys):
        return False
    rectified, raw = (image_size(content, key) for key in keys)
    return hints.size == rectified != raw


RAW = Format(
    "kitti-raw",
    "KITTI raw data's calib_cam_to_cam.txt (S_00, K_00, D_00, R_00, T_00 …)",
    "m",
    lambda document: any(f"{key}_{pair[0]}" in document.content for key in ("K", "P_rect") for pair in _CHOICES),
    _read_raw,
    cameras=lambda documents: sorted(sum(_CHOICES, ()), key=lambda name: name not in _pair(documents[0])),
    syntax=COLONS,
    blank=lambda rig, syntax: (_BLANK.format("00", *rig.left.size) + _BLANK.format("01", *rig.right.size),),
    write=_write_raw,
)
