"""OpenCV's FileStorage: YAML, XML or JSON with K1 (or M1) D1 K2 D2 R T; the stereo_calib sample writes two files."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._lens_numbers import check_held, coefficients
from stereorecal.io.formats._matrix_values import Array, derived_values, matrix_values, size_of
from stereorecal.io.formats._model_names import model_named
from stereorecal.io.formats._numbers import image_size, numbers, pixels
from stereorecal.io.formats._rectification_matrices import (
    RectifyOptions,
    essential,
    fundamental,
    options_of,
    rectification_of,
)
from stereorecal.io.formats.text._document import Syntax

NAME = "opencv"
ABOUT = "OpenCV's FileStorage (K1 or M1, D1, K2, D2, R, T), one file, or intrinsics and extrinsics"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML, ".xml": Syntax.XML, ".json": Syntax.JSON}
FILES = 1
UNIT = None

_MATRICES = ("K", "M", "cameraMatrix", "camera_matrix_", "intrinsic")
_DISTORTIONS = ("D", "distCoeffs", "dist_coeffs_", "distortion_coefficients_")
_SIZES = ("imageSize", "image_size", "imgSize", "size", "res1")
_REGIONS = {"roi1": ("roi1", "validRoi1", "validROI1", "validPixROI1"), "roi2": ("roi2", "validRoi2", "validROI2",
            "validPixROI2")}  # fmt: skip
_COUNTS = (4, 5, 8, 12, 14)
_RECTIFY = RectifyOptions(alpha=1.0)  # of stereo_calib
# Nothing else tells the coefficients of cv2.fisheye from those of a pinhole: OpenCV's own sample writes the first.
_FISHEYE, _MODEL = "fisheye_model", "distortion_model"


def can_read(documents: Documents) -> bool:
    """Whether there are intrinsics of cameras 1 and 2, or R and T, under names that are usual."""
    content = _content(documents)
    intrinsics = any(f"{name}{side}" in content for name in _MATRICES for side in (1, 2))
    whole = {"R", "T"} <= content.keys() and "K_left" not in content
    return intrinsics and whole if len(documents) == 2 else intrinsics or whole


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of OpenCV's files; image size as in the file, else that of the hints, since OpenCV's own programs
    write none."""
    content = _content(documents)
    _check_both_parts(content)
    matrix, distortion = _name(content, _MATRICES), _name(content, _DISTORTIONS)
    size, model = _size(content, hints), _model(content)
    left, right = (
        Camera(
            size,
            numbers(content, f"{matrix}{side}", (3, 3)),
            numbers(content, f"{distortion}{side}", (-1,)),
            model=model,
        )
        for side in (1, 2)
    )
    return StereoRig.from_rotation(left, right, numbers(content, "R", (3, 3)), numbers(content, "T", (3,)))


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """One file, as OpenCV itself writes it."""
    ending = next(ending for ending, of_ending in SYNTAX.items() if of_ending is syntax)
    storage = cv2.FileStorage(ending, cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.startWriteStruct("imageSize", cv2.FILE_NODE_SEQ | cv2.FILE_NODE_FLOW)
    for pixel in rig.left.size:
        storage.write("", pixel)
    storage.endWriteStruct()
    if {rig.left.model, rig.right.model} == {"equidistant"}:
        storage.write(_FISHEYE, 1)
    for side, camera in enumerate((rig.left, rig.right), start=1):
        storage.write(f"K{side}", np.eye(3))
        storage.write(f"D{side}", np.zeros((1, _lens(camera).size)))
    for key, shape in {
        "R": (3, 3),
        "T": (3, 1),
        "R1": (3, 3),
        "R2": (3, 3),
        "P1": (3, 4),
        "P2": (3, 4),
        "Q": (4, 4),
    }.items():
        storage.write(key, np.zeros(shape))
    return (storage.releaseAndGetString(),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """OpenCV's files: R and T; what the file has of R1, R2, P1, P2, Q (with its own options, or those of stereo_calib),
    E and F."""
    if rig.left.size != rig.right.size:
        raise InputError("the cameras have images of different sizes; write the rig as kalibr, ros or basalt instead.")
    content = _content(target.documents)
    matrix, distortion = _name(content, _MATRICES), _name(content, _DISTORTIONS)
    values = dict(_cameras(rig, target, content, matrix, distortion))
    made = rectification_of(rig, _rectify_options(target, content)) | {"E": essential(rig), "F": fundamental(rig)}
    regions = {name: made.pop(key) for key, names in _REGIONS.items() for name in names if key in made}
    arrays: dict[str, Array] = {"R": np.asarray(rig.rotation), "T": np.asarray(rig.translation), **made, **regions}
    values.update(derived_values(content, arrays))
    return tuple(
        document.with_values({keys: value for keys, value in values.items() if keys[0] in document.content})
        for document in target.documents
    )


def _rectify_options(target: Target, content: Mapping[str, Any]) -> RectifyOptions:
    try:
        P1, P2 = (numbers(content, key, (3, 4)) for key in ("P1", "P2"))
    except InputError:  # missing, or no matrix: it is written anew in any case
        return _RECTIFY
    return options_of(read(target.documents, target.hints), P1, P2, _RECTIFY) if np.any(P1) else _RECTIFY


def _cameras(rig: StereoRig, target: Target, content: Mapping[str, Any], matrix: str, distortion: str) -> Iterator:
    for side, camera, wanted in ((1, rig.left, target.left), (2, rig.right, target.right)):
        if wanted:
            key = f"{distortion}{side}"
            counts = [count for count in _COUNTS if count >= size_of(content, (key,))]
            lens = _lens(camera, counts)
            yield from matrix_values(content, (f"{matrix}{side}",), np.asarray(camera.matrix)).items()
            yield from matrix_values(content, (key,), lens).items()


def _lens(camera: Camera, counts: Sequence[int] = _COUNTS) -> Array:
    check_held(camera, (Camera.model, "equidistant"), "OpenCV")
    fisheye = camera.model == "equidistant"
    return np.asarray(camera.distortion) if fisheye else coefficients(camera, counts, "OpenCV", "")


def _model(content: Mapping[str, Any]) -> str:
    """Of both lenses.

    Raises:
        UnsupportedModelError: if the file names one that is not known.
    """
    stated = content.get(_MODEL)
    return "equidistant" if content.get(_FISHEYE) else Camera.model if stated is None else model_named(stated)


def _check_both_parts(content: Mapping[str, Any]) -> None:
    """Refuse one file of the two that stereo_calib writes."""
    cameras = any(f"{name}1" in content or f"{name}2" in content for name in _MATRICES)
    if not cameras or not {"R", "T"} & content.keys():
        there, missing = ("intrinsics", "extrinsics (R, T)") if cameras else ("extrinsics", "intrinsics (K1 or M1 …)")
        raise InputError(
            f"there are {there} only, no {missing}: OpenCV's stereo_calib writes intrinsics.yml and extrinsics.yml; "
            "give both, intrinsics first."
        )


def _content(documents: Documents) -> dict[str, Any]:
    return {key: item for document in documents for key, item in document.content.items()}


def _name(content: Mapping[str, Any], names: tuple[str, ...]) -> str:
    return next((name for name in names for side in (1, 2) if f"{name}{side}" in content), names[0])


def _size(content: Mapping[str, Any], hints: Hints) -> tuple[int, int]:
    for key in _SIZES:
        if key in content:
            return image_size(content, key)
    if "image_width" in content:
        return pixels(content, "image_width"), pixels(content, "image_height")
    if hints.size is None:
        raise InputError(
            "the file has no image size (imageSize); give size=(width, height), on the command line --size WxH."
        )
    return hints.size
