"""OpenCV's FileStorage: YAML, XML or JSON with K1 (or M1) D1 K2 D2 R T, or the same matrices under other names, nested,
in one file or in several; the stereo_calib sample writes two."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import JSON, YAML, Documents, Format, Hints, Syntax, Target, pose, rig_of
from stereorecal.io.formats._matrix_search import (
    WAY_OUT,
    Entry,
    cameras_in,
    entries_of,
    lenses_in,
    may_be_between,
    may_be_camera,
    rectifications_in,
    rotation_in,
    size_in,
    translation_in,
)
from stereorecal.io.formats._numbers import (
    Array,
    camera_matrix,
    check_held,
    coefficients,
    image_size,
    lens_coefficients,
    matrix_values,
    model_named,
    numbers,
    rotation_matrix,
    size_of,
)
from stereorecal.io.formats._rectification_matrices import (
    RectifyOptions,
    essential,
    fundamental,
    options_of,
    rectification_of,
)
from stereorecal.io.formats.text._nodes import Keys, Values

_MATRICES = ("K", "M", "cameraMatrix", "camera_matrix_", "intrinsic")
_DISTORTIONS = ("D", "distCoeffs", "dist_coeffs_", "distortion_coefficients_")
_SIZES = ("imageSize", "image_size", "imgSize", "size", "res1")

_REGIONS = {"roi1": ("roi1", "validRoi1", "validROI1", "validPixROI1"), "roi2": ("roi2", "validRoi2", "validROI2",
            "validPixROI2")}  # fmt: skip
_COUNTS = (4, 5, 8, 12, 14)
_RECTIFY = RectifyOptions(alpha=1.0)  # of stereo_calib
# Nothing else tells the coefficients of cv2.fisheye from those of a pinhole: OpenCV's own sample writes the first.
_LISTED = 8
_FISHEYE, _MODEL = "fisheye_model", "distortion_model"
_SHAPES = {"R": (3, 3), "T": (3, 1), "R1": (3, 3), "R2": (3, 3), "P1": (3, 4), "P2": (3, 4), "Q": (4, 4)}


@dataclass(frozen=True)
class _Matrices:
    """The values of some documents, and which of them is which.

    Attributes:
        content: every value by its name: the keys that lead to it, joined by dots.
        places: for each name, the number of its document, and its keys.
        names: of K1, D1, K2, D2, R, T, and, where the file has them, R1, R2, P1, P2; of what is not found, the name
            that OpenCV's samples give it.
    """

    content: Mapping[str, Any]
    places: Mapping[str, Keys]
    names: Mapping[str, str]
    entries: Sequence[Entry]

    def has(self, *roles: str) -> bool:
        """Whether all of these are there."""
        return all(self.names.get(role) in self.content for role in roles)

    def own_name(self, key: str) -> str | None:
        """What a derived matrix, such as P1 or Q, is called, if it is there under its usual key."""
        if key in self.names or key in self.content:
            return self.names.get(key, key)
        inside = [name for name, place in self.places.items() if place[-1] == key]
        return inside[0] if len(inside) == 1 else None

    def size(self, hints: Hints) -> tuple[int, int]:
        """(width, height) of the images, of the file or else of the hints."""
        for key in _SIZES:
            if key in self.content:
                return image_size(self.content, key)
        if "image_width" in self.content:
            return image_size(self.content, "image_width", "image_height")
        return size_in(self.entries) or hints.needed_size("the file has no image size (imageSize)")


def _matrices(documents: Documents) -> _Matrices:
    """What documents hold."""
    entries = entries_of(documents)
    content, names = {entry.name: entry.value for entry in entries}, dict[str, str]()
    for role, usual, found_in in (("K", _MATRICES, cameras_in), ("D", _DISTORTIONS, lenses_in)):
        by_sides = [{side for side in (1, 2) if f"{name}{side}" in content} for name in usual]
        exact = next((name for name, sides in zip(usual, by_sides, strict=True) if len(sides) == 2), None)
        found = None if exact else found_in(entries)
        exact = exact or next((name for name, sides in zip(usual, by_sides, strict=True) if sides), None)
        for index, side in enumerate((1, 2)):
            names[f"{role}{side}"] = found[index].name if found else f"{exact or usual[0]}{side}"
    for role, one_in in (("R", rotation_in), ("T", translation_in)):
        one = None if role in content else one_in(entries)
        names[role] = one.name if one else role
    if not {names["R"], names["T"]} & content.keys():
        rectified = rectifications_in(entries)
        for role, pair in zip("RP", rectified or (), strict=False):
            names |= {f"{role}{side}": entry.name for side, entry in enumerate(pair, start=1)}
    return _Matrices(content, {entry.name: entry.place for entry in entries}, names, entries)


def _looks_together(documents: Documents) -> bool:
    """Whether there are the camera matrices of two cameras, or a rotation and a translation between them."""
    try:
        matrices = _matrices(documents)
    except InputError:  # two readings, which `read` names
        return True
    cameras, between = matrices.has("K1", "K2"), matrices.has("R", "T")
    both = cameras and (between or matrices.has("R1", "R2", "P1", "P2"))
    if {"K_left", "K_right"} & matrices.content.keys():
        return both
    exact = any(f"{name}{side}" in matrices.content for name in _MATRICES for side in (1, 2))
    if len(documents) == 2:
        return both or (exact and {"R", "T"} <= matrices.content.keys())
    return cameras or between or exact


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; the image size is that of the file, else that of the hints, since OpenCV's own programs write none."""
    matrices = _matrices(documents)
    content, names = matrices.content, matrices.names
    implied = not matrices.has("R") and not matrices.has("T") and matrices.has("R1", "R2", "P1", "P2")
    if not implied:
        _check_both_parts(matrices)
    size, model = matrices.size(hints), _model(content)
    cameras = []
    for side in (1, 2):
        matrix, key = camera_matrix(content, names[f"K{side}"]), names[f"D{side}"]
        distortion = lens_coefficients(content, key) if model == Camera.model else numbers(content, key, (-1,))
        with about(names[f"K{side}"]):
            cameras.append(Camera(size, matrix, distortion, model=model))
    left, right = cameras
    if implied:
        return rig_of(left, right, pose(*_implied(content, names)))
    rotation, translation = rotation_matrix(content, names["R"]), numbers(content, names["T"], (3,))
    return rig_of(left, right, pose(rotation, translation))


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """One file, as OpenCV itself writes it."""
    ending = next(ending for ending, of_ending in FORMAT.syntax.items() if of_ending is syntax)
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
    for key, shape in _SHAPES.items():
        storage.write(key, np.zeros(shape))
    return (storage.releaseAndGetString(),)


def _write(rig: StereoRig, target: Target) -> Sequence[Values]:
    """R and T; what the file has of R1, R2, P1, P2, Q (with its own options, or those of stereo_calib), E and F."""
    if rig.left.size != rig.right.size:
        raise InputError("the cameras have images of different sizes; write the rig as kalibr, ros or basalt instead.")
    matrices = _matrices(target.documents)
    values = dict(_cameras(rig, target, matrices))
    made = rectification_of(rig, _rectify_options(target, matrices)) | {"E": essential(rig), "F": fundamental(rig)}
    regions = {name: made.pop(key) for key, names in _REGIONS.items() for name in names if key in made}
    arrays: dict[str, Array] = {"R": np.asarray(rig.rotation), "T": np.asarray(rig.translation), **made, **regions}
    for key, array in arrays.items():
        name = matrices.own_name(key) or key
        if name in matrices.content:
            values |= matrix_values(matrices.content, (name,), array)
    placed = [dict[Keys, Any]() for _ in target.documents]
    for (name, *rest), value in values.items():
        document, *place = matrices.places[str(name)]
        placed[int(document)][(*place, *rest)] = value
    return placed


def _rectify_options(target: Target, matrices: _Matrices) -> RectifyOptions:
    try:
        P1, P2 = (numbers(matrices.content, matrices.own_name(key) or key, (3, 4)) for key in ("P1", "P2"))
    except InputError:  # missing, or no matrix: it is written anew in any case
        return _RECTIFY
    return options_of(_read(target.documents, target.hints), P1, P2, _RECTIFY) if np.any(P1) else _RECTIFY


def _cameras(rig: StereoRig, target: Target, matrices: _Matrices) -> Iterator[tuple[Keys, Any]]:
    content, names = matrices.content, matrices.names
    for side, camera in target.cameras(rig):
        key = names[f"D{side + 1}"]
        counts = [count for count in _COUNTS if count >= size_of(content, (key,))]
        lens = _lens(camera, counts)
        yield from matrix_values(content, (names[f"K{side + 1}"],), np.asarray(camera.matrix)).items()
        yield from matrix_values(content, (key,), lens).items()


def _implied(content: Mapping[str, Any], names: Mapping[str, str]) -> tuple[Array, Array]:
    """R and T of the rotations that rectify, and the projections: R = R2^T R1, T = R2^T (P2[0, 3] / P2[0, 0], 0, 0); of
    cameras one above the other R2^T (0, P2[1, 3] / P2[1, 1], 0)."""
    R1, R2 = (numbers(content, names[key], (3, 3)) for key in ("R1", "R2"))
    P1, P2 = (numbers(content, names[key], (3, 4)) for key in ("P1", "P2"))
    if np.any(P1[:, 3]) or P2[2, 3] or np.all(P2[:2, 3]) or P2[0, 0] <= 0 or P2[1, 1] <= 0:
        raise InputError(
            f"R and T cannot be told from {names['P1']} and {names['P2']}, whose fourth columns are not (0, 0, 0) and "
            "(t, 0, 0) or (0, t, 0); add R and T to the file."
        )
    return R2.T @ R1, R2.T @ np.array([P2[0, 3] / P2[0, 0], P2[1, 3] / P2[1, 1], 0.0])


def _lens(camera: Camera, counts: Sequence[int] = _COUNTS) -> Array:
    check_held(camera, (Camera.model, "equidistant"), "OpenCV")
    fisheye = camera.model == "equidistant"
    return np.asarray(camera.distortion) if fisheye else coefficients(camera, counts, "OpenCV", "")


def _model(content: Mapping[str, Any]) -> str:
    """The model of both lenses."""
    if any(re.fullmatch(r"(.*[._])?xi[_\d]*", str(name), re.IGNORECASE) for name in content):
        raise UnsupportedModelError(
            "xi is a lens of cv2.omnidir; give sr.StereoRig.from_matrices(…, model='omni') with D = xi k1 k2 p1 p2."
        )
    stated = content.get(_MODEL)
    return "equidistant" if content.get(_FISHEYE) else Camera.model if stated is None else model_named(stated)


def _check_both_parts(matrices: _Matrices) -> None:
    """Refuse one file of the two that stereo_calib writes, and matrices whose names do not say what they are."""
    content, names = matrices.content, matrices.names
    cameras = any(names[role] in content for role in ("K1", "K2"))
    between = bool({names["R"], names["T"]} & content.keys())
    if cameras and between:
        return
    of_kind = [str(entry) for entry in matrices.entries if (may_be_between if cameras else may_be_camera)(entry)]
    if of_kind and (cameras or between):
        missing = "rotation (R) and translation (T)" if cameras else "a left and a right camera matrix (K1, K2)"
        raise InputError(f"{missing} are not found among {', '.join(of_kind[:_LISTED])}; {WAY_OUT}")
    there, missing = ("intrinsics", "extrinsics (R, T)") if cameras else ("extrinsics", "intrinsics (K1 or M1 …)")
    raise InputError(
        f"there are {there} only, no {missing}: OpenCV's stereo_calib writes intrinsics.yml and extrinsics.yml; "
        "give both, intrinsics first."
    )


FORMAT = Format(
    "opencv",
    "OpenCV's FileStorage (K1 or M1, D1, K2, D2, R, T), one file, or intrinsics and extrinsics",
    None,
    lambda document: _looks_together((document,)),
    _read,
    looks_together=_looks_together,
    syntax={**YAML, ".xml": Syntax.XML, **JSON},
    blank=_blank,
    write=_write,
)
