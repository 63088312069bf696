"""EuRoC's sensor.yaml (ASL format), one file for each camera: its intrinsics and its pose on the body."""

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats._format import YAML, Format, Lens, Pose, Syntax, Table
from stereorecal.io.formats._numbers import check_held

_TERMS = "distortion_coefficients"
# Names of OpenCV's k1 k2 p1 p2: in EuRoC's files, and in those of Kalibr and ROS.
_RADIAL_TANGENTIAL = ("radial-tangential", "radtan", "plumb_bob")
_TABLE = Table(
    size="resolution",
    matrix="intrinsics",
    words=("camera_model", "distortion_model"),
    lenses={f"pinhole {word}": Lens(_TERMS) for word in _RADIAL_TANGENTIAL}
    | {"pinhole equidistant": Lens(_TERMS, "equidistant")},
    pose=Pose("T_BS", inverted=True),
    holder="EuRoC's radial-tangential model",
)
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


def _blank(rig: StereoRig, syntax: Syntax) -> list[str]:
    """Two blank files, with the left camera as the body."""
    texts = []
    for camera in (rig.left, rig.right):
        check_held(camera, (Camera.model, "equidistant"), "EuRoC's layout")
        model = _RADIAL_TANGENTIAL[0] if camera.model == Camera.model else camera.model
        texts.append(_BLANK.format(width=camera.size[0], height=camera.size[1], model=model))
    return texts


FORMAT = Format(
    "euroc",
    "EuRoC or ASL (sensor.yaml of cam0 and of cam1)",
    "m",
    lambda document: "T_BS" in document.content,
    _TABLE.read,
    files=2,
    syntax=YAML,
    blank=_blank,
    write=_TABLE.write,
)
