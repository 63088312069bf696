"""Which two cameras of a file are the left and the right one: the first and the second, unless others are chosen."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import AS_IN_FILE, StereoRig, euler_from_rotation
from stereorecal.io.formats._format import Documents, Format, Hints

_SIDES = ("left", "right")  # names of the first two cameras in every format
_NUMBERS = ("0", "1")  # and in those that name none


def chosen_cameras(format: Format, documents: Documents, hints: Hints) -> tuple[Hints, bool]:
    """What a format is to read, and whether the second one of its two cameras is the left one."""
    names = tuple(format.cameras(documents)) if format.cameras else _NUMBERS
    given = hints.cameras
    for first, second in (_SIDES, names[:2] if len(names) > 1 else _NUMBERS):
        if given in (None, (first, second), (second, first)):
            return replace(hints, cameras=None), given == (second, first)
    if format.cameras is None:
        raise InputError(
            f"the cameras are {_listed(given)}, and {format.name} names none; give right,left if the second one of the "
            "file is the left one, or leave it out."
        )
    if len(set(given)) < 2 or not set(given) <= set(names):
        raise InputError(
            f"the cameras are {_listed(given)}, and the file has {_listed(names)}; give the left and the right one."
        )
    return hints, False


def checked_cameras(given: object) -> tuple[str, str] | None:
    """The names of the left and the right camera, as they were given."""
    if given is None:
        return None
    if not isinstance(given, tuple | list) or len(given) != 2 or not all(isinstance(name, str) for name in given):
        raise InputError(
            f'cameras is {given!r}; give the names of the left and the right camera, such as ("cam1", "cam0"), or '
            '("right", "left") to exchange them.'
        )
    return given[0], given[1]


def left_first(rig: StereoRig, exchanged: bool, hints: Hints, files: int) -> StereoRig:
    """A rig as its file has it, with the left camera first.

    Args:
        exchanged: whether the second one of the file is the left one.
        hints, files: with which it was read, and how many files it takes, for the message.
    """
    rig = _exchanged(rig) if exchanged else rig
    x, y, z = np.asarray(rig.side_by_side().translation)
    if x >= max(abs(y), abs(z)):
        raise InputError(
            f"left and right are swapped: T[0] must be negative (x_right = R x_left + T); {_way(hints, files)}"
        )
    return replace(rig, source=None)


def as_in_file(rig: StereoRig, exchanged: bool) -> StereoRig:
    """The inverse of `left_first`, of images as they were taken."""
    rig = rig.as_taken()
    return _exchanged(replace(rig, source=AS_IN_FILE)) if exchanged else rig


def _way(hints: Hints, files: int) -> str:
    if hints.cameras is not None:
        return f"the cameras were given as {_listed(hints.cameras)}: give {_listed(hints.cameras[::-1])}."
    if files == 2:
        return (
            "give the left camera's file first, or, if it was, correct the sign of the translation (P[0, 3] in ROS's "
            "files)."
        )
    return (
        'if the first camera of the file is the right one, give cameras=("right", "left"), on the command line '
        "--cameras right,left; if both are upside down, turn images and calibration by 180 degrees."
    )


def _exchanged(rig: StereoRig) -> StereoRig:
    back = np.asarray(rig.rotation).T
    extrinsics = np.concatenate([euler_from_rotation(back), -back @ np.asarray(rig.translation)])
    return replace(rig, left=rig.right, right=rig.left, extrinsics=extrinsics)


def _listed(names: Sequence[str]) -> str:
    return ",".join(names) if names else "no camera"
