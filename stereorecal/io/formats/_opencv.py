"""OpenCV's FileStorage: YAML, XML or JSON with K1 (or M1) D1 K2 D2 R T, or the same matrices under other names, nested,
in one file or in several; the stereo_calib sample writes two."""

import re
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import JSON, YAML, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._kitti import camera_and_place
from stereorecal.io.formats._matrix_search import MATRICES, Matrices, matrices_in
from stereorecal.io.formats._numbers import (
    Array,
    camera_matrix,
    coefficients,
    lens_coefficients,
    matrix_values,
    model_named,
    numbers,
    rotation_matrix,
    size_of,
)
from stereorecal.io.formats._poses import pose, pose_of_rectified, rig_of
from stereorecal.io.formats._rectification_matrices import (
    RectifyOptions,
    epipolar_matrices,
    options_of,
    rectification_of,
)
from stereorecal.io.formats.text._nodes import Keys, Values

_REGIONS = ("roi", "validRoi", "validROI", "validPixROI")  # names of roi1 and roi2, without the number
_COUNTS = (4, 5, 8, 12, 14)
_RECTIFY = RectifyOptions(alpha=1.0)  # of stereo_calib
# Nothing else tells the coefficients of cv2.fisheye from those of a pinhole: OpenCV's own sample writes the first.
_FISHEYE, _MODEL = "fisheye_model", "distortion_model"
_SHAPES = {"R": (3, 3), "T": (3, 1), "R1": (3, 3), "R2": (3, 3), "P1": (3, 4), "P2": (3, 4), "Q": (4, 4)}


def _looks_together(documents: Documents) -> bool:
    """Whether there are the camera matrices of two cameras, or a rotation and a translation between them."""
    try:
        matrices = matrices_in(documents)
    except InputError:  # two readings, which `read` names
        return True
    cameras, between = matrices.has("K1", "K2"), matrices.has("R", "T")
    both = cameras and (between or matrices.has("R1", "R2", "P1", "P2"))
    if {"K_left", "K_right"} & matrices.content.keys():
        return both
    exact = any(f"{name}{side}" in matrices.content for name in MATRICES for side in (1, 2))
    if len(documents) == 2:
        return both or (exact and {"R", "T"} <= matrices.content.keys())
    return cameras or between or exact


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; the image size is that of the file, else that of the hints, since OpenCV's own programs write none."""
    matrices = matrices_in(documents)
    content, names = matrices.content, matrices.names
    implied = not matrices.has("R") and not matrices.has("T") and matrices.has("R1", "R2", "P1", "P2")
    if not implied:
        matrices.check_whole()
    size = matrices.size(hints)
    if any(re.fullmatch(r"(.*[._])?xi[_\d]*", str(name), re.IGNORECASE) for name in content):
        raise UnsupportedModelError(
            "xi is a lens of cv2.omnidir; give sr.StereoRig.from_matrices(…, model='omni') with D = xi k1 k2 p1 p2."
        )
    model = "equidistant" if content.get(_FISHEYE) else model_named(content.get(_MODEL))
    cameras = []
    for side in (1, 2):
        matrix, key = camera_matrix(content, names[f"K{side}"]), names[f"D{side}"]
        distortion = lens_coefficients(content, key) if model == Camera.model else numbers(content, key, (-1,))
        with about(names[f"K{side}"]):
            cameras.append(Camera(size, matrix, distortion, model=model))
    left, right = cameras
    if implied:
        first, second = (numbers(content, names[key], (3, 3)) for key in ("R1", "R2"))
        (_, place), (_, other) = (camera_and_place(content, names[key], size) for key in ("P1", "P2"))
        return rig_of(left, right, pose_of_rectified((first, place), (second, other)))
    rotation, translation = rotation_matrix(content, names["R"]), numbers(content, names["T"], (3,))
    return rig_of(left, right, pose(rotation, translation))


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """One file, as OpenCV itself writes it."""
    storage = cv2.FileStorage(f".{syntax.name.lower()}", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.startWriteStruct("imageSize", cv2.FILE_NODE_SEQ | cv2.FILE_NODE_FLOW)
    for pixel in rig.left.size:
        storage.write("", pixel)
    storage.endWriteStruct()
    if {rig.left.model, rig.right.model} == {"equidistant"}:
        storage.write(_FISHEYE, 1)
    for side, camera in enumerate((rig.left, rig.right), start=1):
        storage.write(f"K{side}", np.eye(3))
        storage.write(f"D{side}", np.zeros((1, coefficients(camera, _COUNTS, "OpenCV", "").size)))
    for key, shape in _SHAPES.items():
        storage.write(key, np.zeros(shape))
    return (storage.releaseAndGetString(),)


def _write(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> Sequence[Values]:
    """R and T; what the file has of R1, R2, P1, P2, Q (with its own options, or those of stereo_calib), E and F."""
    matrices, arrays = matrices_in(documents), dict[str, Array]()
    for side, camera in changed.items():
        least = size_of(matrices.content, (matrices.names[f"D{side + 1}"],))
        arrays[f"K{side + 1}"] = np.asarray(camera.matrix)
        arrays[f"D{side + 1}"] = coefficients(camera, _COUNTS, "OpenCV", "", least)
    made = rectification_of(rig, _rectify_options(documents, hints, matrices))
    arrays |= {"R": np.asarray(rig.rotation), "T": np.asarray(rig.translation), **made, **epipolar_matrices(rig)}
    arrays |= {f"{name}{side}": made[f"roi{side}"] for name in _REGIONS for side in (1, 2)}
    found = [dict[Keys, Any]() for _ in documents]
    for key, array in arrays.items():
        name = matrices.own_name(key)
        if name in matrices.content:
            document, *place = matrices.entries[name].place
            values = matrix_values(matrices.content, (name,), array)
            found[int(document)] |= {(*place, *rest): value for (_, *rest), value in values.items()}
    return found


def _rectify_options(documents: Documents, hints: Hints, matrices: Matrices) -> RectifyOptions:
    try:
        P1, P2 = (numbers(matrices.content, matrices.own_name(key), (3, 4)) for key in ("P1", "P2"))
    except InputError:  # missing, or no matrix: it is written anew in any case
        return _RECTIFY
    return options_of(lambda: _read(documents, hints), P1, P2, _RECTIFY)


FORMAT = Format(
    "opencv",
    "OpenCV's FileStorage (K1 or M1, D1, K2, D2, R, T), one file, or intrinsics and extrinsics",
    None,
    lambda document: _looks_together((document,)),
    _read,
    one_size=True,
    looks_together=_looks_together,
    syntax={**YAML, ".xml": Syntax.XML, **JSON},
    blank=_blank,
    write=_write,
)
