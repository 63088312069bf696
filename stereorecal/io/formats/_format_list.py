"""The list of formats: found by name, or by the content of a file."""

from pathlib import Path

from stereorecal._errors import InputError, checked_choice
from stereorecal.io.formats import (
    _basalt,
    _boofcv,
    _camera_info,
    _depthai,
    _euroc,
    _kalibr,
    _kitti_odometry,
    _kitti_raw,
    _matlab,
    _middlebury,
    _mrcal,
    _opencv,
    _orb_slam,
    _pinhole_and_baseline,
    _realsense,
    _ros,
    _stereorecal,
    _vins,
    _zed,
)
from stereorecal.io.formats._calibration_template import said_of
from stereorecal.io.formats._format import Documents, Format

# The first that can read a file reads it.
FORMATS: tuple[Format, ...] = (
    _stereorecal,
    _kalibr,
    _boofcv,
    _basalt,
    _depthai,
    _ros,
    _camera_info,
    _euroc,
    _middlebury,
    _kitti_raw,
    _kitti_odometry,
    _matlab,
    _mrcal,
    _vins,
    _orb_slam,
    _pinhole_and_baseline,
    _zed,
    _realsense,
    _opencv,
)
NAMES = tuple(format.NAME for format in FORMATS)
_USUAL: dict[str, Format] = {".json": _stereorecal, ".yaml": _opencv, ".yml": _opencv, ".xml": _opencv}


def named(name: str) -> Format:
    """The format of that name.

    Raises:
        InputError: if there is none.
    """
    return FORMATS[NAMES.index(checked_choice(name, NAMES, "calibration format"))]


def recognised(documents: Documents) -> Format | None:
    """The format of these files, by what is in them; None if it is none that is known."""
    return next((format for format in FORMATS if format.can_read(documents)), None)


def half_of(documents: Documents) -> Format | None:
    """The format of which a single file is one of two."""
    return recognised((documents[0], documents[0])) if len(documents) == 1 else None


def usual(path: Path) -> Format:
    """The format of a new file of that name.

    Raises:
        InputError: if the ending does not tell.
    """
    ending = path.suffix.lower()
    if ending not in ("", *_USUAL):
        raise InputError(
            f"{path}: the file name's ending does not identify the format; say which with format=, on the command "
            "line --to."
        )
    return _USUAL.get(ending, _stereorecal)


def unknown(documents: Documents) -> str:
    """What to say where nothing is recognised."""
    known = f"the format is unknown; expected one of {', '.join(NAMES)} (documentation, page Your data)."
    return known + said_of(documents)
