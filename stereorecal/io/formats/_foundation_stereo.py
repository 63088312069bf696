"""A text of a camera matrix and a baseline, as FoundationStereo has it: of rectified images, one matrix for both."""

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Documents, Format, Hints, Syntax, pose, rig_of
from stereorecal.io.formats._numbers import numbers
from stereorecal.io.formats.text._document import Document


def _looks(document: Document) -> bool:
    """Whether there are nine numbers on a line, or on three, and one more on the last."""
    if document.syntax is not Syntax.NUMBERS:
        return False
    return [np.size(row) for row in document.content["numbers"]] in ([9, 1], [3, 3, 3, 1])


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of rectified images; their size is that of the hints."""
    flat = numbers({"the text": [x for row in documents[0].content["numbers"] for x in row]}, "the text", (10,))
    size = hints.needed_size("the file has no image size")
    if not flat[9] > 0:
        raise InputError(f"the last number, the baseline, is {flat[9]:g}; correct it.")
    camera = Camera(size, flat[:9].reshape(3, 3))
    return rig_of(camera, camera, pose(np.eye(3), np.array([-flat[9], 0.0, 0.0])))


FORMAT = Format(
    "foundationstereo",
    "FoundationStereo's K.txt: the nine numbers of the camera matrix, and the baseline in metres",
    "m",
    _looks,
    _read,
)
