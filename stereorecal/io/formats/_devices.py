"""Factory calibrations of devices: DepthAI's EEPROM as JSON (OAK cameras); and, at each of their resolutions, ZED's
SN….conf, an INI file, and what RealSense's `rs-enumerate-devices -c` prints, saved as a text."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import JSON, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._numbers import (
    coefficients,
    image_size,
    numbers,
    pinhole_matrix,
    scalars,
    unsupported,
    value,
)
from stereorecal.io.formats._poses import Link, inverse, left_to_right, motions_from, moved, pose, rig_of
from stereorecal.io.formats._rectification_matrices import RectifyOptions, rectification_of
from stereorecal.io.formats.text._nodes import Keys, Values, at

# --- DepthAI: the stereo pair that the file names, or the sockets 1 (left) and 2 (right)

_STEREO, _NOWHERE = "stereoRectificationData", -1
_SOCKETS = {"leftCameraSocket": 1, "rightCameraSocket": 2}
_EYE = np.eye(3).tolist()
_MODELS = (Camera.model, "equidistant")  # by cameraType; a fisheye is OpenCV's, and uses the first four coefficients
_WORDS = ("batchName", "boardConf", "boardCustom", "boardName", "boardRev", "deviceName", "hardwareConf", "productName")


def _cameras_of_depthai(documents: Documents) -> tuple[str, ...]:
    """The numbers of the sockets, those of the stereo pair first."""
    content = documents[0].content
    sockets = (entry[0] for entry in content["cameraData"] if isinstance(entry, list) and entry)
    return tuple(dict.fromkeys(map(str, (*_sockets(content, Hints()), *sockets))))


def _read_depthai(documents: Documents, hints: Hints) -> StereoRig:
    """The rig by its calibrated translations, never those of the drawing (`specTranslation`). Images
    of another size are taken for those of a mode of the sensor: scaled, or cut above and below, or both."""
    content = documents[0].content
    sockets = one, other = _sockets(content, hints)
    left, right = (_camera_of_depthai(content, socket, hints) for socket in sockets)
    motion = motions_from(str(one), _links(content, sockets)).get(str(other))
    if motion is None:
        raise InputError(
            f"the extrinsics of sockets {one} and {other} do not lead to each other; calibrate the device again."
        )
    return rig_of(left, right, motion)


def _blank_depthai(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """A device of two cameras and no name, the left one of which stands on the right one."""
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    alone = {"rotationMatrix": _EYE, "specTranslation": zero, "toCameraSocket": _NOWHERE, "translation": zero}
    left, right = _SOCKETS.values()
    on_right = alone | {"specTranslation": zero | {"x": -float(rig.baseline)}, "toCameraSocket": right}
    cameras = [
        {
            "cameraType": int(camera.model == "equidistant"),
            "distortionCoeff": [0.0] * 14,
            "extrinsics": extrinsics,
            "height": camera.size[1],
            "intrinsicMatrix": _EYE,
            "lensPosition": 0,
            "specHfovDeg": float(np.degrees(2.0 * np.arctan(0.5 * camera.size[0] / camera.matrix[0, 0]))),
            "width": camera.size[0],
        }
        for camera, extrinsics in ((rig.left, on_right), (rig.right, alone))
    ]
    content = {
        **dict.fromkeys(_WORDS, ""),
        "batchTime": 0,
        "boardOptions": 0,
        "cameraData": [[left, cameras[0]], [right, cameras[1]]],
        "housingExtrinsics": alone,
        "imuExtrinsics": alone,
        "miscellaneousData": [],
        _STEREO: {**_SOCKETS, "rectifiedRotationLeft": _EYE, "rectifiedRotationRight": _EYE},
        "stereoEnableDistortionCorrection": False,
        "stereoUseSpecTranslation": False,
        "version": 7,
        "verticalCameraSocket": _NOWHERE,
    }
    return (strict_json_text(content),)


def _write_depthai(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> list[Values]:
    """The pose that links the two cameras, and the rectifying rotations (as `cv2.stereoRectify`)."""
    content, values = documents[0].content, dict[Keys, Any]()
    sockets = one, other = _sockets(content, hints)
    for link, motion in moved(_links(content, sockets), str(one), str(other), left_to_right(rig)):
        place = (*_data(content, int(link.camera))[0], "extrinsics")
        values[(*place, "rotationMatrix")] = motion[:3, :3].tolist()
        values |= {(*place, "translation", axis): float(motion[row, 3]) for row, axis in enumerate("xyz")}
    if sockets == _sockets(content, Hints()) and at(content, (_STEREO, "rectifiedRotationLeft")):
        made = rectification_of(rig, RectifyOptions())
        values[(_STEREO, "rectifiedRotationLeft")] = made["R1"].tolist()
        values[(_STEREO, "rectifiedRotationRight")] = made["R2"].tolist()
    for side, camera in changed.items():
        data, stated = _data(content, sockets[side])
        size, least = image_size(stated, "width", "height"), len(stated["distortionCoeff"])
        lens = coefficients(camera, (4, 5, 8, 12, 14), "DepthAI", "opencv", least)
        values[(*data, "intrinsicMatrix")] = np.asarray(_uncut(camera, size).matrix).tolist()
        values[(*data, "distortionCoeff")] = np.pad(lens, (0, max(0, least - lens.size))).tolist()
    return [values]


def _sockets(content: Mapping[str, Any], hints: Hints) -> tuple[int, int]:
    """The sockets of the left and the right camera."""
    if hints.cameras is not None:
        return int(hints.cameras[0]), int(hints.cameras[1])
    stated = content.get(_STEREO) or {}
    left, right = (stated.get(key, usual) for key, usual in _SOCKETS.items())
    return (left, right) if isinstance(left, int) and isinstance(right, int) and min(left, right) >= 0 else (1, 2)


def _data(content: Mapping[str, Any], socket: int) -> tuple[Keys, Mapping[str, Any]]:
    """Where the camera in a socket stands, and what the file says of it."""
    for index, entry in enumerate(content["cameraData"]):
        if isinstance(entry, list) and len(entry) == 2 and entry[0] == socket and isinstance(entry[1], Mapping):
            return ("cameraData", index, 1), entry[1]
    raise InputError(f"cameraData has no camera in socket {socket}; give the file of a calibrated stereo device.")


def _links(content: Mapping[str, Any], sockets: tuple[int, int]) -> list[Link]:
    """How the two cameras stand: on each other, or both on a third one."""
    links = []
    for socket in sockets:
        stated = value(_data(content, socket)[1], "extrinsics")
        shift, on = scalars(value(stated, "translation"), "xyz"), stated.get("toCameraSocket")
        motion = pose(numbers(stated, "rotationMatrix", (3, 3)), shift)
        links += [Link(str(socket), str(on), motion, inverted=True)] if isinstance(on, int) and on >= 0 else []
    return links


def _camera_of_depthai(content: Mapping[str, Any], socket: int, hints: Hints) -> Camera:
    _, data = _data(content, socket)
    with about(f"socket {socket}"):
        kind = data.get("cameraType", 0)
        if kind not in (0, 1):
            raise unsupported(f"cameraType {kind}")
        size, matrix = image_size(data, "width", "height"), numbers(data, "intrinsicMatrix", (3, 3))
        lens = numbers(data, "distortionCoeff", (-1,))
        camera = Camera(size, matrix, lens[:4] if kind else lens, model=_MODELS[kind])
    scaled_size = _before_the_cut(size, hints.size or size)
    return camera if scaled_size is None else camera.resized(scaled_size).cropped(hints.size or size)


def _before_the_cut(whole: tuple[int, int], size: tuple[int, int]) -> tuple[int, int] | None:
    """The size of the images of a sensor before rows were cut from the top and the bottom: of the same shape as the
    whole, or a whole number of times smaller, as its modes are (1280x720 of 1280x800, and 640x360). None if the size is
    no such mode."""
    if whole[0] * size[1] == whole[1] * size[0]:
        return size
    times, rest = divmod(whole[0], size[0])
    mode = (size[0], whole[1] // max(times, 1))
    return mode if times and not rest and not whole[1] % times and mode[1] > size[1] else None


def _uncut(camera: Camera, whole: tuple[int, int]) -> Camera:
    """The camera of the whole sensor, from that of one of its modes."""
    before = _before_the_cut(whole, camera.size) or camera.size
    matrix = np.array(camera.matrix, float)
    matrix[1, 2] += (before[1] - camera.size[1]) // 2
    return replace(camera, size=before, matrix=matrix).resized(whole)


DEPTHAI = Format(
    "depthai",
    "DepthAI's EEPROM (JSON with cameraData, stereoRectificationData)",
    "cm",
    lambda document: isinstance(document.content.get("cameraData"), list),
    _read_depthai,
    cameras=_cameras_of_depthai,
    syntax=JSON,
    blank=_blank_depthai,
    write=_write_depthai,
)

# --- ZED. As Stereolabs' own calibration tool writes it: RX, CV and RZ are the rotation vector of OpenCV's R, Baseline
# is -T[0], TY and TZ are T[1] and T[2].

_SIZES = {"VGA": (672, 376), "HD": (1280, 720), "FHD": (1920, 1080), "2K": (2208, 1242), "SVGA": (960, 600),
          "FHD1200": (1920, 1200), "QHDPLUS": (3200, 1800), "4K": (3840, 2160)}  # fmt: skip
_LENS = ("K1", "K2", "P1", "P2", "K3", "K4", "K5", "K6", "S1", "S2", "S3", "S4")
_SIDES = ("LEFT", "RIGHT")
_SECTIONS = {f"{side}_CAM_{name}" for side in _SIDES for name in _SIZES}
_WIDEST = 0.1  # radians between the two cameras


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
    "zed",
    "ZED's factory calibration, SN….conf (LEFT_CAM_HD, RIGHT_CAM_HD, STEREO)",
    "mm",
    lambda document: "STEREO" in document.content and bool(_SECTIONS & document.content.keys()),
    _read_zed,
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
    modes: dict[str, dict[tuple[int, int], list[Mapping[str, Any]]]] = {name: {} for name in names}
    for printed in content["intrinsics"]:
        name = printed["name"]
        if name in modes:
            with about(name):
                modes[name].setdefault(image_size(printed, "Width", "Height"), []).append(printed)
    size = hints.mode_among([size for size in modes[names[0]] if size in modes[names[1]]])
    left, right = (_camera_of_realsense(of_camera[size], name, size) for name, of_camera in modes.items())
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
                raise unsupported(model)
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
