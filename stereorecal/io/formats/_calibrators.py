"""What calibration programs write: MATLAB's stereoParameters as a struct (toStruct in a .mat file, or jsonencode in a
JSON file), mrcal's two .cameramodel files, and BoofCV's stereo YAML."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import METRES, Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Documents, Format, Hints
from stereorecal.io.formats._numbers import image_size, numbers, pinhole_matrix, unsupported, value
from stereorecal.io.formats._poses import Motion, inverse, pose, rig_of, stated_pose
from stereorecal.io.formats._table import Lens, Pose, Table, places
from stereorecal.io.formats.text._document import Document

# --- MATLAB multiplies rows from the right (IntrinsicMatrix and RotationOfCamera2 are transposed; K and PoseCamera2 of
# newer releases are not), counts pixels from 1, and has sizes as (rows, columns).

_CAMERAS = ("CameraParameters1", "CameraParameters2")
_UNITS = {"": "mm", "millimeters": "mm", "millimetres": "mm", "mm": "mm", "centimeters": "cm", "centimetres": "cm",
          "cm": "cm", "meters": "m", "metres": "m", "m": "m", "inches": "in", "in": "in"}  # fmt: skip
_DIFFERENT = 1e-3


def _read_matlab(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a struct, wherever it is in the file; lengths in millimetres."""
    whole = documents[0].content
    content = _struct(whole) or whole
    left, right = (_camera_of_matlab(content[name], name, hints) for name in _CAMERAS)
    rotation, translation = _motion(content)
    word = next((content[name].get("WorldUnits") for name in _CAMERAS if content[name].get("WorldUnits")), "")
    unit = _UNITS.get(str(word).lower())
    if unit is None:
        raise InputError(f"WorldUnits is {word!r}; write one of millimeters, centimeters, meters, inches.")
    return rig_of(left, right, pose(rotation, translation * (METRES[unit] / METRES["mm"])))


def _struct(content: Any, depth: int = 0) -> Mapping[str, Any] | None:
    if not isinstance(content, Mapping) or depth > 3:
        return None
    if all(isinstance(content.get(name), Mapping) for name in _CAMERAS):
        return content
    return next((found for inside in content.values() if (found := _struct(inside, depth + 1)) is not None), None)


def _motion(content: Mapping[str, Any]) -> tuple[Mat3, Any]:
    """R and T from the first camera to the second."""
    newer, found = content.get("PoseCamera2"), []
    if "RotationOfCamera2" in content:
        found.append((numbers(content, "RotationOfCamera2", (3, 3)).T, numbers(content, "TranslationOfCamera2", (3,))))
    if isinstance(newer, Mapping):
        with about("PoseCamera2"):
            if "R" in newer:
                found.append((numbers(newer, "R", (3, 3)), numbers(newer, "Translation", (3,))))
            else:
                matrix = stated_pose(newer, "A")
                found.append((matrix[:3, :3], matrix[:3, 3]))
    if not found:
        value(content, "RotationOfCamera2")
    if any(np.abs(R - found[0][0]).max() > _DIFFERENT for R, _ in found):
        raise InputError("RotationOfCamera2 is not the transpose of PoseCamera2's R; remove the one that is wrong.")
    return found[0]


def _camera_of_matlab(content: Mapping[str, Any], name: str, hints: Hints) -> Camera:
    content = content["Intrinsics"] if isinstance(content.get("Intrinsics"), Mapping) else content
    with about(name):
        if "MappingCoefficients" in content:
            raise UnsupportedModelError("MATLAB's fisheye model is not supported; undistort the images.")
        matrix = numbers(content, "K" if "K" in content else "IntrinsicMatrix", (3, 3))
        matrix = matrix if np.any(matrix[:2, 2]) else matrix.T
        matrix = matrix - np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        if content.get("ImageSize"):
            high, wide = image_size(content, "ImageSize")
        else:
            wide, high = hints.needed_size("ImageSize is empty")
        radial, tangential = (numbers(content, f"{kind}Distortion", (-1,)) for kind in ("Radial", "Tangential"))
        if radial.size not in (2, 3) or tangential.size != 2:
            raise InputError("RadialDistortion has two or three numbers, and TangentialDistortion two; correct them.")
        return Camera((wide, high), matrix, np.array([*radial[:2], *tangential, *radial[2:]]))


MATLAB = Format(
    "matlab",
    "MATLAB's stereoParameters as a struct (toStruct, jsonencode)",
    "mm",
    lambda document: _struct(document.content) is not None,
    _read_matlab,
)

# --- mrcal: one file for each camera, whose extrinsics are from a common reference

_MODELS = {"LENSMODEL_PINHOLE": 4, "LENSMODEL_OPENCV4": 8, "LENSMODEL_OPENCV5": 9, "LENSMODEL_OPENCV8": 12,
           "LENSMODEL_OPENCV12": 16}  # fmt: skip
_EXTRINSICS = ("rt_cam_ref", "extrinsics")  # of mrcal 3, and of those before


def _read_mrcal(documents: Documents, hints: Hints) -> StereoRig:
    """The rig: the motion from the left camera to the reference, and on to the right one."""
    (left, to_left), (right, to_right) = (_camera_of_mrcal(document) for document in documents)
    with about(" and ".join(document.name for document in documents)):
        return rig_of(left, right, to_right @ inverse(to_left))


def _camera_of_mrcal(document: Document) -> tuple[Camera, Motion]:
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
        motion = numbers(content, key, (6,))
        if not np.linalg.norm(motion[:3]) < 2 * np.pi:
            raise InputError(f"the first three numbers of {key} are no rotation vector in radians; correct them.")
        camera = Camera(image_size(content, "imagersize"), pinhole_matrix(intrinsics[:4]), intrinsics[4:])
    return camera, pose(cv2.Rodrigues(motion[:3])[0], motion[3:])


MRCAL = Format(
    "mrcal",
    "mrcal's left and right .cameramodel",
    "m",
    lambda document: {"lensmodel", "imagersize"} <= document.content.keys(),
    _read_mrcal,
    files=2,
)

# --- BoofCV: two cameras, and the pose that takes points from the right one to the left one

_PINHOLE, _LENS = "pinhole_radial_tangential", "{}/radial_tangential"
_TABLE = Table(
    size=places("{}/pinhole", "width height"),
    matrix=places("{}/pinhole", "fx fy cx cy"),
    lenses={"": Lens(places(_LENS, "t1 t2"), radial=f"{_LENS}/radial", counts=(5,))},
    pose=Pose("rightToLeft/rotation", places("rightToLeft", "x y z"), inverted=True, between=True),
    holder="BoofCV's model",
    fixed={"model": "stereo_camera", "{}/model": _PINHOLE, "{}/pinhole/skew": 0.0, f"{_LENS}/radial": [0.0, 0.0]},
)


def _read_boofcv(documents: Documents, hints: Hints) -> StereoRig:
    for side in _TABLE.names:
        with about(side):
            camera = value(documents[0].content, side)
            if camera.get("model", _PINHOLE) != _PINHOLE:
                raise unsupported(camera["model"])
            if float(numbers(value(camera, "pinhole"), "skew", ())) != 0.0:
                raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
    return _TABLE.read(documents, hints)


BOOFCV = Format(
    "boofcv",
    "BoofCV's stereo calibration (YAML with left, right, rightToLeft)",
    None,
    lambda document: isinstance(document.content.get("rightToLeft"), Mapping),
    _read_boofcv,
    syntax=YAML,
    blank=_TABLE.blank,
    write=_TABLE.write,
)
