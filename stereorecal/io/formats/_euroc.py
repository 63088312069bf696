"""EuRoC's sensor.yaml (ASL format), one file for each camera: its intrinsics and its pose on the body."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._lens_numbers import check_held, check_model, coefficients, pinhole_matrix, pinhole_numbers
from stereorecal.io.formats._matrix_values import matrix_values
from stereorecal.io.formats._numbers import image_size, numbers, value
from stereorecal.io.formats._rigid_motions import Pose, inverse, left_to_right, rig_of
from stereorecal.io.formats.text._document import Document, Syntax
from stereorecal.io.formats.text._keys import Keys

NAME = "euroc"
ABOUT = "EuRoC or ASL (sensor.yaml of cam0 and of cam1)"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}
FILES = 2
UNIT = "m"

# The name in EuRoC's files, and those of Kalibr and ROS for the same model: OpenCV's k1 k2 p1 p2.
_RADIAL_TANGENTIAL = ("radial-tangential", "radtan", "plumb_bob")
_EQUIDISTANT = "equidistant"
_BLANK = """\
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [1.0, 0.0, 0.0, 0.0,
         0.0, 1.0, 0.0, 0.0,
         0.0, 0.0, 1.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
resolution: [{width}, {height}]
camera_model: pinhole
intrinsics: [0.0, 0.0, 0.0, 0.0]
distortion_model: {model}
distortion_coefficients: [0.0, 0.0, 0.0, 0.0]
"""


def can_read(documents: Documents) -> bool:
    """Whether both files have a pose on the body."""
    return len(documents) == 2 and all("T_BS" in document.content for document in documents)


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two EuRoC files, each with the pose T_BS of its camera, x_body = R_i x_i + T_i: left to right is
    inv(T_BS1) T_BS0."""
    (left, left_pose), (right, right_pose) = (_camera(document) for document in documents)
    with about(f"{documents[0].name} and {documents[1].name}"):
        return rig_of(left, right, inverse(right_pose) @ left_pose)


def _camera(document: Document) -> tuple[Camera, Pose]:
    content = document.content
    with about(document.name):
        stated = value(content, "distortion_model")
        check_model(stated, (*_RADIAL_TANGENTIAL, _EQUIDISTANT), value(content, "camera_model"))
        matrix = pinhole_matrix(numbers(content, "intrinsics", (4,)))
        lens = numbers(content, "distortion_coefficients", (-1,))
        model = _EQUIDISTANT if stated == _EQUIDISTANT else Camera.model
        camera = Camera(image_size(content, "resolution"), matrix, lens, model=model)
        return camera, _pose(content)


def _pose(content: Mapping[str, Any]) -> Pose:
    return numbers(content, "T_BS", (4, 4))


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """Both files; the left camera is the body."""
    texts = []
    for camera in (rig.left, rig.right):
        check_held(camera, (Camera.model, _EQUIDISTANT), "EuRoC's layout")
        model = _EQUIDISTANT if camera.model == _EQUIDISTANT else _RADIAL_TANGENTIAL[0]
        texts.append(_BLANK.format(width=camera.size[0], height=camera.size[1], model=model))
    return tuple(texts)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """Two EuRoC files: the right camera's pose on the body changes, the left one's stays."""
    left, right = target.documents
    poses = (None, _pose(left.content) @ inverse(left_to_right(rig)))
    sides = ((left, rig.left, target.left), (right, rig.right, target.right))
    texts = []
    for (document, camera, wanted), pose in zip(sides, poses, strict=True):
        values: dict[Keys, Any] = {} if pose is None else matrix_values(document.content, ("T_BS",), np.asarray(pose))
        if wanted:
            values[("intrinsics",)] = pinhole_numbers(camera)
            if camera.model == _EQUIDISTANT:
                lens = np.asarray(camera.distortion)
            else:
                lens = coefficients(camera, (4,), "EuRoC's radial-tangential model", "opencv, ros or depthai")
            values[("distortion_coefficients",)] = lens.tolist()
        texts.append(document.with_values(values))
    return tuple(texts)
