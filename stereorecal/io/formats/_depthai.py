"""DepthAI's EEPROM as JSON (OAK cameras): the stereo pair that it names, or the sockets 1 (left) and 2 (right)."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import (
    JSON,
    Documents,
    Format,
    Hints,
    Motion,
    Syntax,
    Target,
    inverse,
    left_to_right,
    pose,
    rig_of,
)
from stereorecal.io.formats._numbers import coefficients, image_size, numbers, scalars, value
from stereorecal.io.formats._rectification_matrices import RectifyOptions, rectification_of
from stereorecal.io.formats.text._nodes import Keys, Values, at

_STEREO, _NOWHERE, _RECTIFY = "stereoRectificationData", -1, RectifyOptions(alpha=0.0)
_SOCKETS = {"leftCameraSocket": 1, "rightCameraSocket": 2}
_EYE = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
_PERSPECTIVE, _FISHEYE = 0, 1  # cameraType; a fisheye is OpenCV's, and uses the first four coefficients
_ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
_WORDS = ("batchName", "boardConf", "boardCustom", "boardName", "boardRev", "deviceName", "hardwareConf", "productName")


def _cameras(documents: Documents) -> tuple[str, ...]:
    """The numbers of the sockets, those of the stereo pair first."""
    content = documents[0].content
    pair = _sockets(content, Hints())
    sockets = (entry[0] for entry in content["cameraData"] if isinstance(entry, list) and entry)
    return tuple(map(str, (*pair, *(socket for socket in sockets if socket not in pair))))


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig by its calibrated translations, never those of the drawing (`specTranslation`). Images
    of another size are taken for those of a mode of the sensor: scaled, or cut above and below, or both."""
    content = documents[0].content
    left, right = (_camera(content, socket, hints) for socket in _sockets(content, hints))
    return rig_of(left, right, _relation(content, hints)[0])


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """A device of two cameras and no name."""
    nominal = {"x": -float(rig.baseline), "y": 0.0, "z": 0.0}
    content = {
        **dict.fromkeys(_WORDS, ""),
        "batchTime": 0,
        "boardOptions": 0,
        "cameraData": [[1, _blank_camera(rig.left, 2, nominal)], [2, _blank_camera(rig.right, _NOWHERE, _ZERO)]],
        "housingExtrinsics": _blank_extrinsics(_NOWHERE, _ZERO),
        "imuExtrinsics": _blank_extrinsics(_NOWHERE, _ZERO),
        "miscellaneousData": [],
        _STEREO: {**_SOCKETS, "rectifiedRotationLeft": _EYE, "rectifiedRotationRight": _EYE},
        "stereoEnableDistortionCorrection": False,
        "stereoUseSpecTranslation": False,
        "version": 7,
        "verticalCameraSocket": _NOWHERE,
    }
    return (strict_json_text(content),)


def _blank_camera(camera: Camera, to_socket: int, nominal: Mapping[str, float]) -> dict[str, Any]:
    return {
        "cameraType": _FISHEYE if camera.model == "equidistant" else _PERSPECTIVE,
        "distortionCoeff": [0.0] * 14,
        "extrinsics": _blank_extrinsics(to_socket, nominal),
        "height": camera.size[1],
        "intrinsicMatrix": _EYE,
        "lensPosition": 0,
        "specHfovDeg": float(np.degrees(2.0 * np.arctan(0.5 * camera.size[0] / camera.matrix[0, 0]))),
        "width": camera.size[0],
    }


def _blank_extrinsics(to_socket: int, nominal: Mapping[str, float]) -> dict[str, Any]:
    place = {"specTranslation": dict(nominal), "toCameraSocket": to_socket, "translation": dict(_ZERO)}
    return {"rotationMatrix": _EYE, **place}


def _write(rig: StereoRig, target: Target) -> list[Values]:
    """The pose that links the two cameras, and the rectifying rotations (as `cv2.stereoRectify`)."""
    content = target.documents[0].content
    sockets = _sockets(content, target.hints)
    _, socket, stated_pose = _relation(content, target.hints)
    moved = stated_pose(left_to_right(rig))
    place = ("cameraData", _index(content, socket), 1, "extrinsics")
    values: dict[Keys, Any] = {(*place, "rotationMatrix"): moved[:3, :3].tolist()}
    values |= {(*place, "translation", axis): float(moved[row, 3]) for row, axis in enumerate("xyz")}
    if sockets == _sockets(content, Hints()) and at(content, (_STEREO, "rectifiedRotationLeft")):
        made = rectification_of(rig, _RECTIFY)
        values[(_STEREO, "rectifiedRotationLeft")] = made["R1"].tolist()
        values[(_STEREO, "rectifiedRotationRight")] = made["R2"].tolist()
    for side, camera in target.cameras(rig):
        data = ("cameraData", _index(content, sockets[side]), 1)
        stated = _data(content, sockets[side])
        size, least = image_size(stated, "width", "height"), len(stated["distortionCoeff"])
        if camera.model == "equidistant":
            lens = np.pad(np.asarray(camera.distortion), (0, max(0, least - 4)))
        else:
            lens = coefficients(camera, [n for n in (4, 5, 8, 12, 14) if n >= least], "DepthAI", "opencv")
        values[(*data, "intrinsicMatrix")] = np.asarray(_uncut(camera, size).matrix).tolist()
        values[(*data, "distortionCoeff")] = lens.tolist()
    return [values]


def _sockets(content: Mapping[str, Any], hints: Hints) -> tuple[int, int]:
    """The sockets of the left and the right camera."""
    if hints.cameras is not None:
        return int(hints.cameras[0]), int(hints.cameras[1])
    stated = content.get(_STEREO) or {}
    left, right = (stated.get(key, usual) for key, usual in _SOCKETS.items())
    return (left, right) if isinstance(left, int) and isinstance(right, int) and min(left, right) >= 0 else (1, 2)


def _index(content: Mapping[str, Any], socket: int) -> int:
    for index, entry in enumerate(content["cameraData"]):
        if isinstance(entry, list) and len(entry) == 2 and entry[0] == socket and isinstance(entry[1], Mapping):
            return index
    raise InputError(f"cameraData has no camera in socket {socket}; give the file of a calibrated stereo device.")


def _data(content: Mapping[str, Any], socket: int) -> Mapping[str, Any]:
    return content["cameraData"][_index(content, socket)][1]


def _camera(content: Mapping[str, Any], socket: int, hints: Hints) -> Camera:
    data = _data(content, socket)
    with about(f"socket {socket}"):
        kind = data.get("cameraType", _PERSPECTIVE)
        if kind not in (_PERSPECTIVE, _FISHEYE):
            raise UnsupportedModelError(
                "the camera is neither of the perspective model (cameraType 0) nor a fisheye (1); undistort the "
                "images, or calibrate it as such."
            )
        size = image_size(data, "width", "height")
        matrix = numbers(data, "intrinsicMatrix", (3, 3))
        lens = numbers(data, "distortionCoeff", (-1,))
        fisheye = kind == _FISHEYE
        camera = Camera(size, matrix, lens[:4] if fisheye else lens, model="equidistant" if fisheye else Camera.model)
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


def _link(content: Mapping[str, Any], socket: int) -> tuple[int, Motion]:
    """To which camera the pose of a camera leads, and the pose."""
    stated = value(_data(content, socket), "extrinsics")
    shift = scalars(value(stated, "translation"), "xyz")
    to = stated.get("toCameraSocket")
    return to if isinstance(to, int) else _NOWHERE, pose(numbers(stated, "rotationMatrix", (3, 3)), shift)


def _relation(content: Mapping[str, Any], hints: Hints) -> tuple[Motion, int, Callable[[Motion], Motion]]:
    """Left to right; the socket of the camera whose stated pose says so, and what makes that pose of left to right."""
    left, right = _sockets(content, hints)
    (from_left, left_pose), (from_right, right_pose) = _link(content, left), _link(content, right)
    if from_left == right:
        return left_pose, left, lambda motion: motion
    if from_right == left:
        return inverse(right_pose), right, inverse
    if from_left == from_right and from_left >= 0:
        return inverse(right_pose) @ left_pose, right, lambda motion: left_pose @ inverse(motion)
    raise InputError(
        f"the extrinsics of sockets {left} and {right} do not lead to each other; calibrate the device again."
    )


FORMAT = Format(
    "depthai",
    "DepthAI's EEPROM (JSON with cameraData, stereoRectificationData)",
    "cm",
    lambda document: isinstance(document.content.get("cameraData"), list),
    _read,
    cameras=_cameras,
    syntax=JSON,
    blank=_blank,
    write=_write,
)
