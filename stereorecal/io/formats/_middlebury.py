"""Middlebury's calib.txt (2014, 2021, MiddEval3): lines `key=values` of a rectified pair."""

from typing import Any

import numpy as np

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._lens_numbers import ROUNDING, check_straight, has_lens, is_turned
from stereorecal.io.formats._numbers import numbers, pixels
from stereorecal.io.formats._rigid_motions import pose, rig_of
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "middlebury"
ABOUT = "Middlebury's calib.txt (cam0=, cam1=, baseline=) of rectified images"
SYNTAX = {".txt": Syntax.EQUALS}
FILES = 1
UNIT = "mm"

_BLANK = "cam0=[0]\ncam1=[0]\ndoffs=0\nbaseline=0\nwidth={}\nheight={}\n"


def can_read(documents: Documents) -> bool:
    """Whether there are lines of a cam0 and a baseline."""
    content = documents[0].content
    return len(documents) == 1 and documents[0].syntax is Syntax.EQUALS and bool({"cam0", "cam1"} & content.keys())


def cameras(documents: Documents) -> tuple[str, ...]:
    """Two."""
    return "cam0", "cam1"


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a Middlebury calib.txt: the cameras have the same orientation; their principal points differ in x, by
    `doffs`."""
    content = documents[0].content
    size = pixels(content, "width"), pixels(content, "height")
    left, right = (Camera(size, numbers(content, key, (3, 3))) for key in ("cam0", "cam1"))
    baseline = float(numbers(content, "baseline", ()))
    return rig_of(left, right, pose(np.eye(3), np.array([-baseline, 0.0, 0.0])))


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """The lines that every scene has, but `ndisp`, which is a fact about the scene."""
    return (_BLANK.format(*rig.left.size),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """A Middlebury calib.txt: the baseline, and doffs; nothing else can change in rectified images."""
    aside = np.abs(np.asarray(rig.translation)[1:]).max() > ROUNDING * float(rig.baseline)
    off_line = is_turned(rig) or aside or rig.left.size != rig.right.size
    check_straight(off_line or has_lens(rig), "Middlebury's calib.txt")
    left, right = np.asarray(rig.left.matrix), np.asarray(rig.right.matrix)
    values: dict[Keys, Any] = {("baseline",): [float(np.copysign(rig.baseline, -rig.translation[0]))]}
    for key, matrix, wanted in (("cam0", left, target.left), ("cam1", right, target.right)):
        if wanted:
            values[(key,)] = matrix.tolist()
    if (target.left or target.right) and "doffs" in target.documents[0].content:
        values[("doffs",)] = [float(right[0, 2] - left[0, 2])]
    return (target.documents[0].with_values(values),)
