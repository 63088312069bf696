"""Basalt's calibration.json: camera-to-IMU poses as quaternions; camera 0 is the left one, camera 1 the right one,
unless others are chosen."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import JSON, Documents, Format, Hints, Syntax, Target
from stereorecal.io.formats._lens_numbers import check_model, coefficients, has_lens, pinhole_matrix, pinhole_numbers
from stereorecal.io.formats._numbers import image_size, scalars, value
from stereorecal.io.formats._rigid_motions import Pose, inverse, left_to_right, pose, rig_of
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import Values, under

_USUAL = ("0", "1")
_PLACE, _TURN = ("px", "py", "pz"), ("qx", "qy", "qz", "qw")
_PINHOLE = ("fx", "fy", "cx", "cy")
_RADTAN8 = "pinhole-radtan8"
_MODELS = {
    "pinhole": (),
    _RADTAN8: ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
    "kb4": ("k1", "k2", "k3", "k4"),
    "ds": ("xi", "alpha"),
    "eucm": ("alpha", "beta"),
}
_LENSES = {"kb4": "equidistant", "ds": "ds", "eucm": "eucm"}  # the others are OpenCV's
# Keys that Basalt's reader requires; the numbers of an unknown IMU are those of its EuRoC example.
_IMU = {
    "calib_accel_bias": [0.0] * 9,
    "calib_gyro_bias": [0.0] * 12,
    "imu_update_rate": 200.0,
    "accel_noise_std": [0.016] * 3,
    "gyro_noise_std": [0.000282] * 3,
    "accel_bias_std": [0.001] * 3,
    "gyro_bias_std": [0.0001] * 3,
    "cam_time_offset_ns": 0,
    "vignette": [],
}


def _looks(document: Document) -> bool:
    """Whether there are poses of cameras on an IMU."""
    inside = document.content.get("value0")
    return isinstance(inside, Mapping) and "T_imu_cam" in inside


def _cameras(documents: Documents) -> tuple[str, ...]:
    """The numbers of the cameras."""
    poses = documents[0].content["value0"]["T_imu_cam"]
    return tuple(map(str, range(len(poses)))) if isinstance(poses, list) else _USUAL


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; left to right is inv(T_imu_cam[1]) T_imu_cam[0]."""
    content, (first, second) = documents[0].content["value0"], map(int, hints.cameras or _USUAL)
    with about("value0"):
        left, right = (_camera(content, index) for index in (first, second))
        return rig_of(left, right, inverse(_pose(content, second)) @ _pose(content, first))


def _of_camera(content: Mapping[str, Any], key: str, index: int) -> Any:
    stated = value(content, key)
    if not isinstance(stated, list) or len(stated) < max(2, index + 1):
        raise InputError(f"{key} has not two cameras; give a calibration of a stereo rig.")
    return stated[index]


def _camera(content: Mapping[str, Any], index: int) -> Camera:
    size = image_size({"resolution": _of_camera(content, "resolution", index)}, "resolution")
    stated = _of_camera(content, "intrinsics", index)
    model = value(stated, "camera_type")
    check_model(model, tuple(_MODELS))
    params = value(stated, "intrinsics")
    matrix = pinhole_matrix(scalars(params, _PINHOLE))
    return Camera(size, matrix, scalars(params, _MODELS[model]), model=_LENSES.get(model, Camera.model))


def _pose(content: Mapping[str, Any], index: int) -> Pose:
    stated = _of_camera(content, "T_imu_cam", index)
    place, turn = scalars(stated, _PLACE), scalars(stated, _TURN)
    if np.linalg.norm(turn) < 1e-6:
        raise InputError("the quaternion of T_imu_cam is zero; correct it.")
    from scipy.spatial.transform import Rotation  # a third of a second to import

    return pose(Rotation.from_quat(turn).as_matrix(), place)


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """One file, with the left camera in the place of the IMU."""
    of_radtan = _RADTAN8 if has_lens(rig) else "pinhole"
    types = {model: name for name, model in _LENSES.items()}
    names = [types.get(camera.model, of_radtan) for camera in (rig.left, rig.right)]
    # Ones are numbers of every lens, so that what is blank can be read.
    lenses = [
        dict.fromkeys(_PINHOLE + _MODELS[name], 1.0) | ({"rpmax": 0.0} if name == _RADTAN8 else {}) for name in names
    ]
    cameras = {
        "T_imu_cam": [dict.fromkeys(_PLACE + _TURN[:3], 0.0) | {"qw": 1.0} for _ in range(2)],
        "intrinsics": [{"camera_type": name, "intrinsics": lens} for name, lens in zip(names, lenses, strict=True)],
        "resolution": [list(camera.size) for camera in (rig.left, rig.right)],
    }
    return (strict_json_text({"value0": cameras | _IMU}),)


def _write(rig: StereoRig, target: Target) -> list[Values]:
    """The right camera's pose on the IMU changes, the left one's stays."""
    content, chosen = target.documents[0].content["value0"], [*map(int, target.hints.cameras or _USUAL)]
    moved = _pose(content, chosen[0]) @ inverse(left_to_right(rig))
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(moved[:3, :3]).as_quat()
    numbers = [*moved[:3, 3].tolist(), *turn.tolist()]
    values = under(("value0", "T_imu_cam", chosen[1]), _PLACE + _TURN, numbers)
    for side, camera in target.cameras(rig):
        kind, lens = content["intrinsics"][chosen[side]]["camera_type"], camera.distortion
        if kind not in _LENSES:
            lens = coefficients(camera, (len(_MODELS[kind]),), "Basalt's model", "opencv, ros or depthai")
        place = ("value0", "intrinsics", chosen[side], "intrinsics")
        values |= under(place, _PINHOLE + _MODELS[kind], [*pinhole_numbers(camera), *lens.tolist()])
        if kind == _RADTAN8:
            values[(*place, "rpmax")] = float(camera.lens_radius)
    return [values]


FORMAT = Format(
    "basalt",
    "Basalt's calibration.json (value0: T_imu_cam, intrinsics, resolution)",
    "m",
    _looks,
    _read,
    cameras=_cameras,
    syntax=JSON,
    blank=_blank,
    write=_write,
)
