"""Basalt's calibration.json: camera-to-IMU poses as quaternions; camera 0 is the left one, camera 1 the right one,
unless others are chosen."""

from collections.abc import Mapping, Sequence

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io.formats._format import JSON, Documents, Format, Target
from stereorecal.io.formats._table import Array, Lens, Pose, Table, places
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import Values

_LENS, _POSE = "value0/intrinsics/{}/intrinsics", "value0/T_imu_cam/{}"
_PINHOLE, _PLACE, _TURN, _RADTAN8 = "fx fy cx cy", "px py pz", "qx qy qz qw", "pinhole-radtan8"
_TERMS = {_RADTAN8: "k1 k2 p1 p2 k3 k4 k5 k6", "kb4": "k1 k2 k3 k4", "ds": "xi alpha", "eucm": "alpha beta"}
_MODELS = {"kb4": "equidistant", "ds": "ds", "eucm": "eucm"}  # the others are OpenCV's
# Keys that Basalt's reader requires; the numbers of an unknown IMU are those of its EuRoC example.
_IMU = {
    "value0/calib_accel_bias": [0.0] * 9,
    "value0/calib_gyro_bias": [0.0] * 12,
    "value0/imu_update_rate": 200.0,
    "value0/accel_noise_std": [0.016] * 3,
    "value0/gyro_noise_std": [0.000282] * 3,
    "value0/accel_bias_std": [0.001] * 3,
    "value0/gyro_bias_std": [0.0001] * 3,
    "value0/cam_time_offset_ns": 0,
    "value0/vignette": [],
}


def _matrix(turn: Array) -> Array:
    if np.linalg.norm(turn) < 1e-6:
        raise InputError("the quaternion of T_imu_cam is zero; correct it.")
    from scipy.spatial.transform import Rotation  # a third of a second to import

    return Rotation.from_quat(turn).as_matrix()


def _quaternion(turn: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(turn).as_quat()


_TABLE = Table(
    size="value0/resolution/{}",
    matrix=places(_LENS, _PINHOLE),
    words=("value0/intrinsics/{}/camera_type",),
    lenses={"pinhole": Lens()}
    | {name: Lens(places(_LENS, terms), _MODELS.get(name, Lens.model)) for name, terms in _TERMS.items()},
    pose=Pose(places(_POSE, _TURN), places(_POSE, _PLACE), inverted=True, decode=_matrix, encode=_quaternion),
    names=("0", "1"),
    holder="Basalt's model",
    fixed=_IMU,
)


def _looks(document: Document) -> bool:
    """Whether there are poses of cameras on an IMU."""
    inside = document.content.get("value0")
    return isinstance(inside, Mapping) and "T_imu_cam" in inside


def _cameras(documents: Documents) -> tuple[str, ...]:
    """The numbers of the cameras."""
    poses = documents[0].content["value0"]["T_imu_cam"]
    return tuple(map(str, range(len(poses)))) if isinstance(poses, list) else _TABLE.names


def _write(rig: StereoRig, target: Target) -> Sequence[Values]:
    """The numbers of the table, and how far a rational lens holds."""
    (values,), content = _TABLE.write(rig, target), target.documents[0].content["value0"]
    chosen = [*map(int, target.hints.cameras or _TABLE.names)]
    limits = {
        ("value0", "intrinsics", chosen[side], "intrinsics", "rpmax"): float(camera.lens_radius)
        for side, camera in target.cameras(rig)
        if content["intrinsics"][chosen[side]]["camera_type"] == _RADTAN8
    }
    return [values | limits]


FORMAT = Format(
    "basalt",
    "Basalt's calibration.json (value0: T_imu_cam, intrinsics, resolution)",
    "m",
    _looks,
    _TABLE.read,
    cameras=_cameras,
    syntax=JSON,
    blank=_TABLE.blank,
    write=_write,
)
