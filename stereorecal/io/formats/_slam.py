"""Settings of odometry and SLAM: EuRoC's sensor.yaml (ASL format), one file for each camera; Basalt's calibration.json,
poses of cameras on an IMU as quaternions; VINS-Fusion's, which name two files of cameras beside (camodocal's); and
ORB-SLAM's, of raw or of rectified images."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about, check_there
from stereorecal.io.formats._format import JSON, YAML, Cameras, Documents, Format, Hints
from stereorecal.io.formats._numbers import (
    Array,
    image_size,
    numbers,
    pinhole_matrix,
    scalars,
    size_of,
    unsupported,
    value,
)
from stereorecal.io.formats._poses import inverse, pose, rig_of, stated_pose
from stereorecal.io.formats._table import Lens, Pose, Table, places
from stereorecal.io.formats.text._document import Document, read_document
from stereorecal.io.formats.text._nodes import Values

_TERMS = "distortion_coefficients"
# Names of OpenCV's k1 k2 p1 p2: in EuRoC's files, and in those of Kalibr and ROS.
_RADIAL_TANGENTIAL = ("radial-tangential", "radtan", "plumb_bob")
_EUROC = Table(
    size="resolution",
    matrix="intrinsics",
    words=("camera_model", "distortion_model"),
    lenses={f"pinhole {word}": Lens(_TERMS) for word in _RADIAL_TANGENTIAL}
    | {"pinhole equidistant": Lens(_TERMS, "equidistant")},
    pose=Pose("T_BS", inverted=True),
    holder="EuRoC's layout",
    fixed={"sensor_type": "camera"},
)
EUROC = Format(
    "euroc",
    "EuRoC or ASL (sensor.yaml of cam0 and of cam1)",
    "m",
    lambda document: "T_BS" in document.content,
    _EUROC.read,
    files=2,
    syntax=YAML,
    blank=_EUROC.blank,
    write=_EUROC.write,
)

# --- Basalt: camera 0 is the left one, camera 1 the right one, unless others are chosen

_INTRINSICS, _STANDS = "value0/intrinsics/{}/intrinsics", "value0/T_imu_cam/{}"
_FOUR, _PLACE, _TURN, _RADTAN8 = "fx fy cx cy", "px py pz", "qx qy qz qw", "pinhole-radtan8"
_TERMS_OF = {_RADTAN8: "k1 k2 p1 p2 k3 k4 k5 k6", "kb4": "k1 k2 k3 k4", "ds": "xi alpha", "eucm": "alpha beta"}
_MODELS_OF = {"kb4": "equidistant", "ds": "ds", "eucm": "eucm"}  # the others are OpenCV's
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


_BASALT = Table(
    size="value0/resolution/{}",
    matrix=places(_INTRINSICS, _FOUR),
    words=("value0/intrinsics/{}/camera_type",),
    lenses={"pinhole": Lens()}
    | {name: Lens(places(_INTRINSICS, terms), _MODELS_OF.get(name, Lens.model)) for name, terms in _TERMS_OF.items()},
    pose=Pose(places(_STANDS, _TURN), places(_STANDS, _PLACE), inverted=True, decode=_matrix, encode=_quaternion),
    names=("0", "1"),
    holder="Basalt's model",
    fixed=_IMU,
)


def _cameras_of_basalt(documents: Documents) -> tuple[str, ...]:
    """The numbers of the cameras."""
    poses = documents[0].content["value0"]["T_imu_cam"]
    return tuple(map(str, range(len(poses)))) if isinstance(poses, list) else _BASALT.names


def _write_basalt(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> Sequence[Values]:
    """The numbers of the table, and how far a rational lens holds."""
    (values,), content = _BASALT.write(rig, documents, hints, changed), documents[0].content["value0"]
    chosen = [*map(int, hints.cameras or _BASALT.names)]
    limits = {
        ("value0", "intrinsics", chosen[side], "intrinsics", "rpmax"): float(camera.lens_radius)
        for side, camera in changed.items()
        if content["intrinsics"][chosen[side]]["camera_type"] == _RADTAN8
    }
    return [values | limits]


BASALT = Format(
    "basalt",
    "Basalt's calibration.json (value0: T_imu_cam, intrinsics, resolution)",
    "m",
    lambda document: isinstance(inside := document.content.get("value0"), Mapping) and "T_imu_cam" in inside,
    _BASALT.read,
    cameras=_cameras_of_basalt,
    syntax=JSON,
    blank=_BASALT.blank,
    write=_write_basalt,
)

# --- VINS-Fusion

_SIZE, _PROJECTION = ("image_width", "image_height"), "projection_parameters"
_RADTAN = places("distortion_parameters", "k1 k2 p1 p2")
_CAMERAS = {  # by model_type
    "PINHOLE": Table(_SIZE, places(_PROJECTION, "fx fy cx cy"), {"": Lens(_RADTAN)}),
    "KANNALA_BRANDT": Table(
        _SIZE, places(_PROJECTION, "mu mv u0 v0"), {"": Lens(places(_PROJECTION, "k2 k3 k4 k5"), "equidistant")}
    ),
    "MEI": Table(
        _SIZE, places(_PROJECTION, "gamma1 gamma2 u0 v0"), {"": Lens(("mirror_parameters/xi", *_RADTAN), "omni")}
    ),
}


def _read_vins(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of VINS' settings and of the files that they name, which lie beside them."""
    content, folder = documents[0].content, Path(documents[0].name).parent
    poses = [stated_pose(content, f"body_T_cam{side}") for side in (0, 1)]
    left, right = (_camera_of_vins(folder / Path(str(value(content, f"cam{side}_calib"))).name) for side in (0, 1))
    return rig_of(left, right, inverse(poses[1]) @ poses[0])


def _camera_of_vins(path: Path) -> Camera:
    check_there(path, "put it beside the settings, which name it.")
    content = read_document(path).content
    with about(path):
        if content.get("model_type") not in _CAMERAS:
            raise unsupported(content.get("model_type"))
        return _CAMERAS[content["model_type"]].camera(content, "")


VINS = Format(
    "vins",
    "settings of VINS-Fusion (body_T_cam0, cam0_calib) beside its two files of cameras",
    "m",
    lambda document: "cam0_calib" in document.content and bool({"body_T_cam0", "body_T_cam1"} & {*document.content}),
    _read_vins,
)

# --- ORB-SLAM: Camera1.fx …, Camera2.fx … and Stereo.T_c1_c2 (or Tlr), or rectified images with Camera.bf

_FIRST = ("Camera1", "Camera")
_RIGHT_TO_LEFT, _BASELINES = ("Stereo.T_c1_c2", "Tlr"), ("Stereo.b", "Camera.bf")
_LENSES = {"pinhole": ("radtan", ("k1", "k2", "p1", "p2", "k3")), "rectified": ("radtan", ()),
           "kannalabrandt8": ("equidistant", ("k1", "k2", "k3", "k4"))}  # fmt: skip


def _looks_like_orb_slam(document: Document) -> bool:
    """Whether there are a first camera and a baseline, of no depth camera (whose baseline is none), and not the raw
    cameras' own matrices, LEFT.K, which say more."""
    content = document.content
    depth = any(str(key).endswith("DepthMapFactor") for key in content)
    stereo = {*_RIGHT_TO_LEFT, *_BASELINES} & content.keys()
    return any(f"{name}.fx" in content for name in _FIRST) and bool(stereo) and not depth and "LEFT.K" not in content


def _read_orb_slam(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of stereo settings; T_c1_c2 takes points from the right camera to the left one."""
    content = documents[0].content
    first = next((name for name in _FIRST if f"{name}.fx" in content), _FIRST[0])
    left = _camera_of_orb_slam(content, first, hints)
    key = next((key for key in _RIGHT_TO_LEFT if key in content), None)
    if key is not None:
        motion = numbers(content, key, (3, 4) if size_of(content, (key,)) == 12 else (4, 4))
        right = _camera_of_orb_slam(content, "Camera2", hints)
        return rig_of(left, right, inverse(pose(motion[:3, :3], motion[:3, 3])))
    if np.any(left.distortion):
        raise InputError(
            "the images are rectified, by the baseline alone (Camera.bf, Stereo.b), but there are coefficients of a "
            "lens; give the settings with Camera2 and Stereo.T_c1_c2, or the calibration of the raw cameras."
        )
    bf = "Stereo.b" not in content
    baseline = float(numbers(content, _BASELINES[bf], ())) / (float(left.matrix[0, 0]) if bf else 1.0)
    return rig_of(left, left, pose(np.eye(3), np.array([-baseline, 0.0, 0.0])))


def _camera_of_orb_slam(content: Mapping[str, Any], name: str, hints: Hints) -> Camera:
    kind = str(content.get("Camera.type", "PinHole")).lower()
    if kind not in _LENSES:
        raise unsupported(content["Camera.type"])
    model, terms = _LENSES[kind]
    four = scalars(content, [f"{name}.{key}" for key in ("fx", "fy", "cx", "cy")])
    lens = scalars({f"{name}.{term}": 0.0 for term in terms} | dict(content), [f"{name}.{term}" for term in terms])
    if "Camera.width" in content:
        size = image_size(content, "Camera.width", "Camera.height")
    else:
        size = hints.needed_size("the file has no Camera.width")
    with about(name):
        return Camera(size, pinhole_matrix(four), lens, model=model)


ORB_SLAM = Format(
    "orbslam",
    "stereo settings of ORB-SLAM (Camera1.fx, Stereo.T_c1_c2, Camera.bf)",
    "m",
    _looks_like_orb_slam,
    _read_orb_slam,
)
