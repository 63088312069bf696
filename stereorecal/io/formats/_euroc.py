"""EuRoC's sensor.yaml (ASL format), one file for each camera: its intrinsics and its pose on the body."""

from stereorecal.io.formats._format import YAML, Format
from stereorecal.io.formats._table import Lens, Pose, Table

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
    holder="EuRoC's layout",
    fixed={"sensor_type": "camera"},
    mapped=True,
)
FORMAT = Format(
    "euroc",
    "EuRoC or ASL (sensor.yaml of cam0 and of cam1)",
    "m",
    lambda document: "T_BS" in document.content,
    _TABLE.read,
    files=2,
    syntax=YAML,
    blank=_TABLE.blank,
    write=_TABLE.write,
)
