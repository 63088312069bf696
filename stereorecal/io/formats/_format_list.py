"""The list of formats: found by name, or by the content of a file."""

from pathlib import Path

from stereorecal._errors import InputError, checked_choice
from stereorecal.io.formats import (
    _basalt,
    _boofcv,
    _depthai,
    _euroc,
    _foundation_stereo,
    _kalibr,
    _kitti,
    _matlab,
    _middlebury,
    _mrcal,
    _opencv,
    _orb_slam,
    _realsense,
    _ros,
    _stereorecal,
    _vins,
    _zed,
)
from stereorecal.io.formats._format import Documents, Format
from stereorecal.io.formats._matrix_search import said_of

# The first that can read a file reads it.
FORMATS = (
    _stereorecal.FORMAT,
    _kalibr.FORMAT,
    _boofcv.FORMAT,
    _basalt.FORMAT,
    _depthai.FORMAT,
    _ros.FORMAT,
    _ros.IN_ONE_FILE,
    _euroc.FORMAT,
    _middlebury.FORMAT,
    _kitti.RAW,
    _kitti.ODOMETRY,
    _matlab.FORMAT,
    _mrcal.FORMAT,
    _vins.FORMAT,
    _orb_slam.FORMAT,
    _foundation_stereo.FORMAT,
    _zed.FORMAT,
    _realsense.FORMAT,
    _opencv.FORMAT,
)
NAMES = tuple(format.name for format in FORMATS)
_USUAL = {".json": _stereorecal.FORMAT, **dict.fromkeys((".yaml", ".yml", ".xml"), _opencv.FORMAT)}


def named(name: str) -> Format:
    """The format of that name."""
    return FORMATS[NAMES.index(checked_choice(name, NAMES, "calibration format"))]


def recognised(documents: Documents) -> Format | None:
    """The format of these files, by what is in them; None if it is none that is known."""
    return next((format for format in FORMATS if format.can_read(documents)), None)


def half_of(documents: Documents) -> Format | None:
    """The format of which a single file is one of two."""
    return recognised((documents[0], documents[0])) if len(documents) == 1 else None


def usual(path: Path) -> Format:
    """The format of a new file of that name."""
    ending = path.suffix.lower()
    if ending not in ("", *_USUAL):
        raise InputError(
            f"{path}: the file name's ending does not identify the format; say which with format=, on the command "
            "line --to."
        )
    return _USUAL.get(ending, _stereorecal.FORMAT)


def unknown(documents: Documents) -> str:
    """What to say where nothing is recognised."""
    known = f"the format is unknown; expected one of {', '.join(NAMES)} (documentation, page Your data)."
    return known + said_of(documents)
