"""EuRoC's sensor.yaml (ASL format), one file for each camera: its intrinsics and its pose on the body."""

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Documents, Format, Hints, Syntax, Target
from stereorecal.io.formats._lens_numbers import check_held, check_model, coefficients, pinhole_matrix, pinhole_numbers
from stereorecal.io.formats._matrix_values import matrix_values
from stereorecal.io.formats._numbers import image_size, numbers, value
from stereorecal.io.formats._rigid_motions import Pose, inverse, left_to_right, rig_of
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import Values

# Names of OpenCV's k1 k2 p1 p2: in EuRoC's files, and in those of Kalibr and ROS.
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


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two files. T_BS is the pose of a camera on the body, x_body = R_i x_i + T_i, so left to right is
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
        return camera, numbers(content, "T_BS", (4, 4))


def _blank(rig: StereoRig, syntax: Syntax) -> list[str]:
    """Two blank files, with the left camera as the body."""
    texts = []
    for camera in (rig.left, rig.right):
        check_held(camera, (Camera.model, _EQUIDISTANT), "EuRoC's layout")
        model = _EQUIDISTANT if camera.model == _EQUIDISTANT else _RADIAL_TANGENTIAL[0]
        texts.append(_BLANK.format(width=camera.size[0], height=camera.size[1], model=model))
    return texts


def _write(rig: StereoRig, target: Target) -> list[Values]:
    """The new values: the right camera's pose on the body changes, the left one's stays."""
    left, right = (document.content for document in target.documents)
    moved = numbers(left, "T_BS", (4, 4)) @ inverse(left_to_right(rig))
    values = [{}, matrix_values(right, ("T_BS",), moved)]
    for side, camera in target.cameras(rig):
        lens = camera.distortion
        if camera.model != _EQUIDISTANT:
            lens = coefficients(camera, (4,), "EuRoC's radial-tangential model", "opencv, ros or depthai")
        values[side] |= {("intrinsics",): pinhole_numbers(camera), ("distortion_coefficients",): lens.tolist()}
    return values


FORMAT = Format(
    "euroc",
    "EuRoC or ASL (sensor.yaml of cam0 and of cam1)",
    "m",
    lambda document: "T_BS" in document.content,
    _read,
    files=2,
    syntax=YAML,
    blank=_blank,
    write=_write,
)
