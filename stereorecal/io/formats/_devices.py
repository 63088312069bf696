"""Factory calibrations of devices at each of their resolutions: ZED's SN….conf, an INI file, and what RealSense's
`rs-enumerate-devices -c` prints, saved as a text."""

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, Syntax, inverse, pose, rig_of
from stereorecal.io.formats._numbers import image_size, numbers, pinhole_matrix, scalars, value
from stereorecal.io.formats.text._document import Document

# --- ZED. As Stereolabs' own calibration tool writes it: RX, CV and RZ are the rotation vector of OpenCV's R, Baseline
# is -T[0], TY and TZ are T[1] and T[2].

_SIZES = {"VGA": (672, 376), "HD": (1280, 720), "FHD": (1920, 1080), "2K": (2208, 1242), "SVGA": (960, 600),
          "FHD1200": (1920, 1200), "QHDPLUS": (3200, 1800), "4K": (3840, 2160)}  # fmt: skip
_LENS = ("K1", "K2", "P1", "P2", "K3", "K4", "K5", "K6", "S1", "S2", "S3", "S4")
_SIDES = ("LEFT", "RIGHT")
_WIDEST = 0.1  # radians between the two cameras


def _looks_like_zed(document: Document) -> bool:
    """Whether there is a left or a right camera at one of the resolutions, and the section of both."""
    keys = document.content.keys()
    return "STEREO" in keys and any(f"{side}_CAM_{name}" in keys for side in _SIDES for name in _SIZES)


def _read_zed(documents: Documents, hints: Hints) -> StereoRig:
    """The rig at the resolution of the images."""
    content = documents[0].content
    modes = {size: name for name, size in _SIZES.items() if all(f"{side}_CAM_{name}" in content for side in _SIDES)}
    size = hints.mode_among(tuple(modes))
    left, right = (_camera_of_zed(content, side, modes[size], size) for side in _SIDES)
    with about("STEREO"):
        stereo = content["STEREO"]
        turn = scalars(stereo, [f"{axis}_{modes[size]}" for axis in ("RX", "CV", "RZ")])
        if np.abs(turn).max() > _WIDEST:
            raise InputError(
                f"RX, CV and RZ are in radians, and the cameras of a ZED are not turned by {np.abs(turn).max():.3g} to "
                "each other; download the file again."
            )
        baseline = float(numbers(stereo, "BASELINE", ()))
        if not baseline > 0.0:
            raise InputError(f"Baseline is {baseline:g}; it is the distance of the cameras in millimetres: correct it.")
        # Old files have TY and TZ for each resolution, and older ones not at all.
        keys = [next((key for key in (f"{axis}_{modes[size]}", axis) if key in stereo), axis) for axis in ("TY", "TZ")]
        aside = scalars(dict.fromkeys(keys, 0.0) | stereo, keys)
    return rig_of(left, right, pose(cv2.Rodrigues(turn)[0], np.array([-baseline, *aside])))


def _camera_of_zed(content: Mapping[str, Any], side: str, name: str, size: tuple[int, int]) -> Camera:
    section, shared = f"{side}_CAM_{name}", f"{side}_DISTO"
    with about(section):
        camera = content[section]
        own = {key: camera[key] for key in _LENS if key in camera}
        lens = content.get(shared, own)
        if any(lens.get(key, 0.0) != number for key, number in own.items()):
            raise InputError(f"its lens is not the one in {shared}; remove the one that is wrong.")
        with about(shared if shared in content else "lens"):
            value(lens, "K1")
            fisheye = "K4" in lens and "P1" not in lens  # the tool writes K1 to K4, and no others, of a fisheye
            names = ("K1", "K2", "K3", "K4") if fisheye else _LENS
            distortion = scalars(dict.fromkeys(names, 0.0) | lens, names)
        matrix = pinhole_matrix(scalars(camera, ("FX", "FY", "CX", "CY")))
        return Camera(size, matrix, distortion, model="equidistant" if fisheye else Camera.model)


ZED = Format(
    "zed", "ZED's factory calibration, SN….conf (LEFT_CAM_HD, RIGHT_CAM_HD, STEREO)", "mm", _looks_like_zed, _read_zed
)

# --- RealSense: both infrared or fisheye cameras

_PAIRS = (("Infrared 1", "Infrared 2"), ("Fisheye 1", "Fisheye 2"))
_KANNALA_BRANDT, _RADTAN = "Kannala Brandt4", "Brown Conrady"
_RECTIFIED = "Y8"  # the format of rectified images; those for a calibration are Y16


def _read_realsense(documents: Documents, hints: Hints) -> StereoRig:
    """The rig at the resolution of the images. "Extrinsic from A To B" maps points of A to B, in metres."""
    content = documents[0].content
    stated = {each["name"] for each in content["intrinsics"]}
    names = next((pair for pair in _PAIRS if set(pair) <= stated), None)
    if names is None:
        raise InputError(
            "it has not the intrinsics of Infrared 1 and Infrared 2, nor those of Fisheye 1 and Fisheye 2; save what "
            "rs-enumerate-devices -c prints, whole."
        )
    modes: list[dict[tuple[int, int], list[Mapping[str, Any]]]] = [{}, {}]
    for printed in content["intrinsics"]:
        if printed["name"] in names:
            with about(printed["name"]):
                of_camera = modes[names.index(printed["name"])]
                of_camera.setdefault(image_size(printed, "Width", "Height"), []).append(printed)
    size = hints.mode_among([size for size in modes[0] if size in modes[1]])
    left, right = (_camera_of_realsense(of_one[size], name, size) for name, of_one in zip(names, modes, strict=True))
    for link in content["extrinsics"]:
        way = link["from"], link["to"]
        if set(way) == {*names}:
            with about(f"Extrinsic from {way[0]} To {way[1]}"):
                flat = numbers(link, "numbers", (12,))
            motion = pose(flat[:9].reshape(3, 3), flat[9:])
            return rig_of(left, right, motion if way == names else inverse(motion))
    raise InputError(
        f"it has no extrinsics from {names[0]} to {names[1]}; save what rs-enumerate-devices -c prints, whole."
    )


def _camera_of_realsense(stated: Sequence[Mapping[str, Any]], name: str, size: tuple[int, int]) -> Camera:
    """The camera that is printed for images of a size, for several of their formats perhaps."""
    cameras = []
    with about(name):
        for each in [each for each in stated if _RECTIFIED in each["kinds"]] or stated:
            matrix = pinhole_matrix(scalars(each, ("Fx", "Fy", "PPX", "PPY")))
            said = each.get("Distortion", "None")
            model = " ".join(map(str, said)) if isinstance(said, list) else str(said)
            lens = numbers(each, "Coeffs", (5,))
            fisheye = model == _KANNALA_BRANDT
            if np.any(lens) and model not in (_RADTAN, _KANNALA_BRANDT):
                raise UnsupportedModelError(
                    f"the distortion model {model!r} is not supported; use rectified images (Y8)."
                )
            terms = lens[:4] if fisheye else lens
            cameras.append(Camera(size, matrix, terms, model="equidistant" if fisheye else Camera.model))
        if any(not np.array_equal(camera.matrix, cameras[0].matrix) for camera in cameras):
            raise InputError(
                f"it has two intrinsics for images of {size[0]}x{size[1]}; keep those of one device, and of the format "
                "of the images."
            )
    return cameras[0]


REALSENSE = Format(
    "realsense",
    "the text that RealSense's rs-enumerate-devices -c prints",
    "m",
    lambda document: document.syntax is Syntax.DEVICES,
    _read_realsense,
)
