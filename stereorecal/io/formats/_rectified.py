"""Texts of rectified pairs, two cameras of one orientation and a baseline: Middlebury's calib.txt (2014, 2021,
MiddEval3), lines `key=values`, and FoundationStereo's K.txt, the numbers of one matrix for both cameras."""

from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._numbers import ROUNDING, check_straight, image_size, numbers
from stereorecal.io.formats._poses import pose, rig_of
from stereorecal.io.formats.text._nodes import Keys, Values

_CAMERAS = ("cam0", "cam1")
# The lines that every scene has, but `ndisp`, which is a fact about the scene.
_BLANK = "cam0=[0 0 0; 0 0 0; 0 0 0]\ncam1=[0 0 0; 0 0 0; 0 0 0]\ndoffs=0\nbaseline=0\nwidth={}\nheight={}\n"


def _read_middlebury(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two cameras whose principal points differ in x, by `doffs`."""
    content = documents[0].content
    size = image_size(content, "width", "height")
    left, right = (Camera(size, numbers(content, key, (3, 3))) for key in _CAMERAS)
    return rig_of(left, right, pose(np.eye(3), np.array([-float(numbers(content, "baseline", ())), 0.0, 0.0])))


def _write_middlebury(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> list[Values]:
    """The baseline, and doffs; nothing else can change in rectified images."""
    aside = np.abs(np.asarray(rig.translation)[1:]).max() > ROUNDING * float(rig.baseline)
    check_straight(rig, "Middlebury's calib.txt", off_line=aside or rig.left.size != rig.right.size)
    values: dict[Keys, Any] = {("baseline",): [float(np.copysign(rig.baseline, -rig.translation[0]))]}
    values |= {(_CAMERAS[side],): np.asarray(camera.matrix).tolist() for side, camera in changed.items()}
    if changed and "doffs" in documents[0].content:
        values[("doffs",)] = [float(rig.right.matrix[0, 2] - rig.left.matrix[0, 2])]
    return [values]


def _read_k_txt(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two equal cameras; the size of the images is that of the hints."""
    flat = numbers({"the text": [x for row in documents[0].content["numbers"] for x in row]}, "the text", (10,))
    size = hints.needed_size("the file has no image size")
    if not flat[9] > 0:
        raise InputError(f"the last number, the baseline, is {flat[9]:g}; correct it.")
    camera = Camera(size, flat[:9].reshape(3, 3))
    return rig_of(camera, camera, pose(np.eye(3), np.array([-flat[9], 0.0, 0.0])))


MIDDLEBURY = Format(
    "middlebury",
    "Middlebury's calib.txt (cam0=, cam1=, baseline=) of rectified images",
    "mm",
    lambda document: document.syntax is Syntax.EQUALS and bool(document.content.keys() & {*_CAMERAS}),
    _read_middlebury,
    cameras=lambda documents: _CAMERAS,
    syntax={".txt": Syntax.EQUALS},
    blank=lambda rig, syntax: (_BLANK.format(*rig.left.size),),
    write=_write_middlebury,
)
FOUNDATION_STEREO = Format(
    "foundationstereo",
    "FoundationStereo's K.txt: the nine numbers of the camera matrix, and the baseline in metres",
    "m",
    # Nine numbers on a line, or on three, and one more on the last.
    lambda document: (
        document.syntax is Syntax.NUMBERS and list(map(np.size, document.content["numbers"])) in ([9, 1], [3, 3, 3, 1])
    ),
    _read_k_txt,
)
