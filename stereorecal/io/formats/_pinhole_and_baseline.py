"""A text of a camera matrix and a baseline, as FoundationStereo has it: of rectified images, one matrix for both."""

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Documents, Hints
from stereorecal.io.formats._numbers import numbers
from stereorecal.io.formats._read_only import SYNTAX as SYNTAX, blank as blank, write as write
from stereorecal.io.formats._rigid_motions import pose, rig_of
from stereorecal.io.formats.text._document import Syntax

NAME = "foundationstereo"
ABOUT = "FoundationStereo's K.txt: the nine numbers of the camera matrix, and the baseline in metres"
FILES = 1
UNIT = "m"


def can_read(documents: Documents) -> bool:
    """Whether there are nine numbers on a line, or on three, and one more on the last."""
    if len(documents) != 1 or documents[0].syntax is not Syntax.NUMBERS:
        return False
    rows = documents[0].content["numbers"]
    return [np.size(row) for row in rows] in ([9, 1], [3, 3, 3, 1])


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of rectified images; their size is that of the hints."""
    flat = numbers({"the text": [x for row in documents[0].content["numbers"] for x in row]}, "the text", (10,))
    if hints.size is None:
        raise InputError("the file has no image size; give size=(width, height), on the command line --size WxH.")
    if not flat[9] > 0:
        raise InputError(f"the last number, the baseline, is {flat[9]:g}; correct it.")
    camera = Camera(hints.size, flat[:9].reshape(3, 3))
    return rig_of(camera, camera, pose(np.eye(3), np.array([-flat[9], 0.0, 0.0])))
