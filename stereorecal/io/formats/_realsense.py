"""The output of `rs-enumerate-devices -c`, saved as a text: both infrared or fisheye cameras of a RealSense."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, Syntax, inverse, pose, rig_of
from stereorecal.io.formats._numbers import numbers, pinhole_matrix, pixels, scalars

_PAIRS = (("Infrared 1", "Infrared 2"), ("Fisheye 1", "Fisheye 2"))
_FISHEYE, _RADTAN = "Kannala Brandt4", "Brown Conrady"
_RECTIFIED = "Y8"  # the format of rectified images; those for a calibration are Y16


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig at the resolution of the images. "Extrinsic from A To B" maps points of A to B, in metres."""
    content = documents[0].content
    stated = {each["name"] for each in content["intrinsics"]}
    names = next((pair for pair in _PAIRS if set(pair) <= stated), None)
    if names is None:
        raise InputError(
            "it has not the intrinsics of Infrared 1 and Infrared 2, nor those of Fisheye 1 and Fisheye 2; save what "
            "rs-enumerate-devices -c prints, whole."
        )
    modes = [_modes(content["intrinsics"], name) for name in names]
    size = hints.mode_among([size for size in modes[0] if size in modes[1]])
    left, right = (_camera(of_one[size], name, size) for name, of_one in zip(names, modes, strict=True))
    return rig_of(left, right, _motion(content["extrinsics"], *names))


def _modes(intrinsics: Sequence[Mapping[str, Any]], name: str) -> dict[tuple[int, int], list[Mapping[str, Any]]]:
    """The printed intrinsics of a camera, by image size."""
    modes: dict[tuple[int, int], list[Mapping[str, Any]]] = {}
    for stated in intrinsics:
        if stated["name"] == name:
            with about(name):
                modes.setdefault((pixels(stated, "Width"), pixels(stated, "Height")), []).append(stated)
    return modes


def _camera(stated: Sequence[Mapping[str, Any]], name: str, size: tuple[int, int]) -> Camera:
    with about(name):
        rectified = [each for each in stated if _RECTIFIED in each["kinds"]] or stated
        cameras = [_one(each, size) for each in rectified]
        if any(not np.array_equal(each.matrix, cameras[0].matrix) for each in cameras):
            raise InputError(
                f"it has two intrinsics for images of {size[0]}x{size[1]}; keep those of one device, and of the format "
                "of the images."
            )
        return cameras[0]


def _one(stated: Mapping[str, Any], size: tuple[int, int]) -> Camera:
    matrix = pinhole_matrix(scalars(stated, ("Fx", "Fy", "PPX", "PPY")))
    model = stated.get("Distortion", "None")
    model = " ".join(map(str, model)) if isinstance(model, list) else str(model)
    lens = numbers(stated, "Coeffs", (5,))
    if model == _FISHEYE:
        return Camera(size, matrix, lens[:4], model="equidistant")
    if np.any(lens) and model != _RADTAN:
        raise UnsupportedModelError(f"the distortion model {model!r} is not supported; use rectified images (Y8).")
    return Camera(size, matrix, lens)


def _motion(extrinsics: Sequence[Mapping[str, Any]], left: str, right: str) -> np.ndarray:
    for stated in extrinsics:
        way = stated["from"], stated["to"]
        if set(way) == {left, right}:
            with about(f"Extrinsic from {way[0]} To {way[1]}"):
                flat = numbers(stated, "numbers", (12,))
            motion = pose(flat[:9].reshape(3, 3), flat[9:])
            return motion if way == (left, right) else inverse(motion)
    raise InputError(f"it has no extrinsics from {left} to {right}; save what rs-enumerate-devices -c prints, whole.")


FORMAT = Format(
    "realsense",
    "the text that RealSense's rs-enumerate-devices -c prints",
    "m",
    lambda document: document.syntax is Syntax.DEVICES,
    _read,
)
