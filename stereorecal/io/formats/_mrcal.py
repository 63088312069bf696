"""mrcal's .cameramodel, one file for each camera, whose extrinsics are from a common reference."""

import cv2
import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, Motion, inverse, pose, rig_of
from stereorecal.io.formats._numbers import image_size, numbers, pinhole_matrix, value
from stereorecal.io.formats.text._document import Document

_MODELS = {"LENSMODEL_PINHOLE": 4, "LENSMODEL_OPENCV4": 8, "LENSMODEL_OPENCV5": 9, "LENSMODEL_OPENCV8": 12,
           "LENSMODEL_OPENCV12": 16}  # fmt: skip
_EXTRINSICS = ("rt_cam_ref", "extrinsics")  # of mrcal 3, and of those before


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two camera models: the motion from the left camera to the reference, and on to the right one."""
    (left, to_left), (right, to_right) = (_camera(document) for document in documents)
    with about(" and ".join(document.name for document in documents)):
        return rig_of(left, right, to_right @ inverse(to_left))


def _camera(document: Document) -> tuple[Camera, Motion]:
    """A camera, and the motion from the reference to it."""
    content = document.content
    with about(document.name):
        model = str(content["lensmodel"])
        if model not in _MODELS:
            raise UnsupportedModelError(
                f"the lens model {model} is not supported; write it as LENSMODEL_OPENCV8 with mrcal-convert-lensmodel."
            )
        intrinsics = numbers(content, "intrinsics", (_MODELS[model],))
        key = next((key for key in _EXTRINSICS if key in content), _EXTRINSICS[1])
        value(content, key)
        motion = numbers(content, key, (6,))
        if not np.linalg.norm(motion[:3]) < 2 * np.pi:
            raise InputError(f"the first three numbers of {key} are no rotation vector in radians; correct them.")
        camera = Camera(image_size(content, "imagersize"), pinhole_matrix(intrinsics[:4]), intrinsics[4:])
    return camera, pose(cv2.Rodrigues(motion[:3])[0], motion[3:])


FORMAT = Format(
    "mrcal",
    "mrcal's left and right .cameramodel",
    "m",
    lambda document: {"lensmodel", "imagersize"} <= document.content.keys(),
    _read,
    files=2,
)
