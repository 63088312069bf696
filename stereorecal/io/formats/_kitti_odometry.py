"""KITTI's calib.txt of odometry and stereo 2012: the projection matrices P0 to P3 of rectified images."""

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._kitti_rectified import camera_and_place, rectified_rig
from stereorecal.io.formats._lens_numbers import check_straight, has_lens, is_turned
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "kitti-odometry"
ABOUT = "KITTI odometry's calib.txt (P0, P1, P2, P3) of rectified images"
SYNTAX = {".txt": Syntax.COLONS}
FILES = 1
UNIT = "m"

_GREY = ("P0", "P1")


def can_read(documents: Documents) -> bool:
    """Whether there are lines P0 or P1, and no raw calibration."""
    (document, *others) = documents
    return not others and document.syntax is Syntax.COLONS and bool({"P0", "P1", "P2", "P3"} & document.content.keys())


def cameras(documents: Documents) -> tuple[str, ...]:
    """P0 to P3."""
    return (*_GREY, "P2", "P3")


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a KITTI odometry file: the grey cameras P0 and P1, unless the hints name others; the file has no image
    size."""
    if hints.size is None:
        raise InputError("the file has no image size; give size=(width, height), on the command line --size WxH.")
    return rectified_rig(documents[0].content, hints.cameras or _GREY, hints.size)


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """Two lines."""
    return (f"P0: {'0 ' * 11}0\nP1: {'0 ' * 11}0\n",)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A KITTI odometry file: the projection matrix of the right camera changes."""
    check_straight(is_turned(rig) or has_lens(rig), "KITTI's calib.txt")
    (document,), keys = target.documents, target.hints.cameras or _GREY
    fresh = target.left and target.right and not any(np.any(document.content[key]) for key in keys)
    place = np.zeros(3) if fresh else camera_and_place(document.content, keys[0], rig.left.size)[1]
    values: dict[Keys, list[float]] = {}
    for key, camera, wanted, shift in (
        (keys[0], rig.left, target.left, place),
        (keys[1], rig.right, True, place + np.asarray(rig.translation)),
    ):
        if wanted:
            matrix = np.asarray(camera.matrix)
            values[(key,)] = np.column_stack([matrix, matrix @ shift]).ravel().tolist()
    return (document.with_values(values),)
