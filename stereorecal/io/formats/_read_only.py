"""Formats that are read and not written: what their modules say where a rig is to be written."""

from typing import NoReturn

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io.formats._format import Format, Target
from stereorecal.io.formats.text._document import Syntax

SYNTAX: dict[str, Syntax] = {}


def refuse_writing(format: Format) -> NoReturn:
    """Refuse to write a rig in a format that is read only.

    Raises:
        InputError: names formats that are written.
    """
    raise InputError(
        f"{format.NAME} ({format.ABOUT}) is read, not written; write the rig as opencv, kalibr or stereorecal instead: "
        "save_rig(…, format=…), --to of convert."
    )


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """None: no file is written."""
    raise AssertionError("this format has no endings of files")


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """None: no file is written."""
    raise AssertionError("this format has no endings of files")
