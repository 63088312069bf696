"""From parsed files to a rig: the list of formats, which two cameras of a file are the left and the right one, and the
unit of lengths."""

from dataclasses import replace

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.geometry import AS_IN_FILE, METRES, Camera, StereoRig, euler_from_rotation, inferred_unit
from stereorecal.io._read_files import about
from stereorecal.io.formats import (
    _calibrators,
    _devices,
    _kalibr,
    _kitti,
    _opencv,
    _rectified,
    _ros,
    _slam,
    _stereorecal,
)
from stereorecal.io.formats._format import Documents, Format, Hints
from stereorecal.io.formats._rig_file import RigFile

# The first that can read a file reads it.
FORMATS = (
    _stereorecal.FORMAT,
    _kalibr.FORMAT,
    _calibrators.BOOFCV,
    _slam.BASALT,
    _devices.DEPTHAI,
    _ros.FORMAT,
    _ros.IN_ONE_FILE,
    _slam.EUROC,
    _rectified.MIDDLEBURY,
    _kitti.RAW,
    _kitti.ODOMETRY,
    _calibrators.MATLAB,
    _calibrators.MRCAL,
    _slam.VINS,
    _slam.ORB_SLAM,
    _rectified.FOUNDATION_STEREO,
    _devices.ZED,
    _devices.REALSENSE,
    _opencv.FORMAT,
)
_SIDES = ("left", "right")  # names of the first two cameras in every format
_NUMBERS = ("0", "1")  # and in those that name none
_STATED = {"matlab": "WorldUnits", "stereorecal": "baseline_m"}  # keys of files that state their unit


def named(name: str) -> Format:
    """The format of that name."""
    known = {format.name: format for format in FORMATS}
    return known[checked_choice(name, known, "calibration format")]


def recognised(documents: Documents) -> Format | None:
    """The format of these files, by what is in them; None if it is none that is known."""
    return next((format for format in FORMATS if format.can_read(documents)), None)


def rig_in(documents: Documents, format: Format, unit: str | None, hints: Hints) -> StereoRig:
    """The rig described by the files of a format; lengths in metres.

    A format's unit is what its programs expect, and ROS, Kalibr and others write whatever the board was measured in: a
    unit that is given holds, else that of the format, else the baseline tells it.
    """
    names = " and ".join(document.name for document in documents)
    if len(documents) < format.files:
        raise InputError(f"{names}: {format.name} has a file for each camera; give the left and the right one.")
    try:
        with about(names if 1 in (len(documents), format.files) else ""):
            asked, exchanged = chosen_cameras(format, documents, hints)
            rig = format.read(documents, asked)
    except (AttributeError, IndexError, KeyError, TypeError):  # a list where there should be keys, and the like
        raise InputError(
            f"{names}: not arranged as {format.name} is ({format.about}); check the file or the format."
        ) from None
    rig = _exchanged(rig) if exchanged else rig
    with about(names):
        x, y, z = np.asarray(rig.side_by_side().translation)
        if x >= max(abs(y), abs(z)):
            raise InputError(
                "left and right are exchanged: T[0] must be negative (x_right = R x_left + T); "
                f"{_way(hints, format.files)}"
            )
        rig = replace(rig, source=None)
        if format.name in _STATED and unit not in (None, format.unit):
            raise InputError(
                f"lengths of a {format.name} file are in the unit that it states ({_STATED[format.name]}), not in "
                f"{unit}; leave the unit out, or correct the file."
            )
    stated = unit or format.unit
    used = stated or inferred_unit(float(rig.baseline))
    # Without terms that are all zero the lens is the same, and so are the digits of what is computed from it.
    rig = replace(rig, left=_trimmed(rig.left), right=_trimmed(rig.right))
    source = RigFile(format.name, documents, hints, used, inferred=stated is None)
    return replace(scaled(rig, METRES[used]), source=source)


def _trimmed(camera: Camera) -> Camera:
    """The camera without those rational, prism and tilt terms that are all zero."""
    lens = np.asarray(camera.distortion)
    return replace(camera, distortion=next((lens[:n] for n in (5, 8, 12) if not np.any(lens[n:])), lens))


def scaled(rig: StereoRig, factor: float) -> StereoRig:
    """The rig with T times a factor."""
    factors = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    return rig if factor == 1.0 else rig.with_extrinsics(rig.extrinsics * factors)


def at_common_size(rig: StereoRig) -> StereoRig:
    """The rig whose larger images are resampled to the size of the smaller ones."""
    if rig.left.size == rig.right.size:
        return rig
    return rig.resized(min(rig.left.size, rig.right.size, key=lambda size: size[0] * size[1]))


# --- which camera is the left one


def chosen_cameras(format: Format, documents: Documents, hints: Hints) -> tuple[Hints, bool]:
    """What a format is to read, and whether the second one of its two cameras is the left one."""
    names = tuple(format.cameras(documents)) if format.cameras else _NUMBERS
    given = hints.cameras
    for first, second in (_SIDES, names[:2] if len(names) > 1 else _NUMBERS):
        if given in (None, (first, second), (second, first)):
            return replace(hints, cameras=None), given == (second, first)
    if format.cameras is None:
        raise InputError(
            f"the cameras are {','.join(given)}, and {format.name} names none; give right,left if the second one of "
            "the file is the left one, or leave it out."
        )
    if len(set(given)) < 2 or not set(given) <= set(names):
        raise InputError(
            f"the cameras are {','.join(given)}, and the file has {','.join(names) or 'no camera'}; give the left and "
            "the right one."
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


def as_in_file(rig: StereoRig, exchanged: bool) -> StereoRig:
    """A rig of images as they were taken, as a file has it whose second camera may be the left one."""
    rig = rig.as_taken()
    return _exchanged(replace(rig, source=AS_IN_FILE)) if exchanged else rig


def _exchanged(rig: StereoRig) -> StereoRig:
    back = np.asarray(rig.rotation).T
    extrinsics = np.concatenate([euler_from_rotation(back), -back @ np.asarray(rig.translation)])
    return replace(rig, left=rig.right, right=rig.left, extrinsics=extrinsics)


def _way(hints: Hints, files: int) -> str:
    """What to do about cameras that are exchanged."""
    if hints.cameras is not None:
        return f"the cameras were given as {','.join(hints.cameras)}: give {','.join(hints.cameras[::-1])}."
    if files == 2:
        return (
            "give the left camera's file first, or, if it was, correct the sign of the translation (P[0, 3] in ROS's "
            "files)."
        )
    return (
        'if the first camera of the file is the right one, give cameras=("right", "left"), on the command line '
        "--cameras right,left; if both are upside down, turn images and calibration by 180 degrees."
    )
