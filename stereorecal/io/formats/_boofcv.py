"""BoofCV's stereo YAML: two cameras, and the pose that takes points from the right one to the left one."""

from collections.abc import Mapping

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Documents, Format, Hints
from stereorecal.io.formats._numbers import check_model, numbers, value
from stereorecal.io.formats._table import Lens, Pose, Table, places

_PINHOLE, _LENS = "pinhole_radial_tangential", "{}/radial_tangential"
_TABLE = Table(
    size=places("{}/pinhole", "width height"),
    matrix=places("{}/pinhole", "fx fy cx cy"),
    lenses={"": Lens(places(_LENS, "t1 t2"), radial=f"{_LENS}/radial", counts=(5,))},
    pose=Pose("rightToLeft/rotation", places("rightToLeft", "x y z"), inverted=True, between=True),
    holder="BoofCV's model",
    fixed={"model": "stereo_camera", "{}/model": _PINHOLE, "{}/pinhole/skew": 0.0, f"{_LENS}/radial": [0.0, 0.0]},
)


def _read(documents: Documents, hints: Hints) -> StereoRig:
    for side in _TABLE.names:
        with about(side):
            camera = value(documents[0].content, side)
            check_model(camera.get("model", _PINHOLE), (_PINHOLE,))
            if float(numbers(value(camera, "pinhole"), "skew", ())) != 0.0:
                raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
    return _TABLE.read(documents, hints)


FORMAT = Format(
    "boofcv",
    "BoofCV's stereo calibration (YAML with left, right, rightToLeft)",
    None,
    lambda document: isinstance(document.content.get("rightToLeft"), Mapping),
    _read,
    syntax=YAML,
    blank=_TABLE.blank,
    write=_TABLE.write,
)
