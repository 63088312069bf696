"""Middlebury's calib.txt (2014, 2021, MiddEval3): lines `key=values` of a rectified pair."""

from typing import Any

import numpy as np

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Documents, Format, Hints, Syntax, Target, pose, rig_of
from stereorecal.io.formats._numbers import ROUNDING, check_straight, numbers, pixels
from stereorecal.io.formats.text._nodes import Keys, Values

_CAMERAS = ("cam0", "cam1")
# The lines that every scene has, but `ndisp`, which is a fact about the scene.
_BLANK = "cam0=[0 0 0; 0 0 0; 0 0 0]\ncam1=[0 0 0; 0 0 0; 0 0 0]\ndoffs=0\nbaseline=0\nwidth={}\nheight={}\n"


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two cameras of one orientation, whose principal points differ in x, by `doffs`."""
    content = documents[0].content
    size = pixels(content, "width"), pixels(content, "height")
    left, right = (Camera(size, numbers(content, key, (3, 3))) for key in _CAMERAS)
    baseline = float(numbers(content, "baseline", ()))
    return rig_of(left, right, pose(np.eye(3), np.array([-baseline, 0.0, 0.0])))


def _write(rig: StereoRig, target: Target) -> list[Values]:
    """The baseline, and doffs; nothing else can change in rectified images."""
    aside = np.abs(np.asarray(rig.translation)[1:]).max() > ROUNDING * float(rig.baseline)
    check_straight(rig, "Middlebury's calib.txt", off_line=aside or rig.left.size != rig.right.size)
    values: dict[Keys, Any] = {("baseline",): [float(np.copysign(rig.baseline, -rig.translation[0]))]}
    values |= {(_CAMERAS[side],): np.asarray(camera.matrix).tolist() for side, camera in target.cameras(rig)}
    if (target.left or target.right) and "doffs" in target.documents[0].content:
        values[("doffs",)] = [float(rig.right.matrix[0, 2] - rig.left.matrix[0, 2])]
    return [values]


FORMAT = Format(
    "middlebury",
    "Middlebury's calib.txt (cam0=, cam1=, baseline=) of rectified images",
    "mm",
    lambda document: document.syntax is Syntax.EQUALS and bool(document.content.keys() & {*_CAMERAS}),
    _read,
    cameras=lambda documents: _CAMERAS,
    syntax={".txt": Syntax.EQUALS},
    blank=lambda rig, syntax: (_BLANK.format(*rig.left.size),),
    write=_write,
)
