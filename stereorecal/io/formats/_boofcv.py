"""BoofCV's stereo YAML: two cameras, and the pose that takes points from the right one to the left one."""

from collections.abc import Mapping

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Documents, Format, Hints, Lens, Pose, Syntax, Table, places
from stereorecal.io.formats._numbers import check_model, numbers, value

_PINHOLE, _LENS = "pinhole_radial_tangential", "{}/radial_tangential"
_TABLE = Table(
    size=places("{}/pinhole", "width height"),
    matrix=places("{}/pinhole", "fx fy cx cy"),
    lenses={"": Lens(places(_LENS, "t1 t2"), radial=f"{_LENS}/radial", counts=(5,))},
    pose=Pose("rightToLeft/rotation", places("rightToLeft", "x y z"), inverted=True, between=True, where="rightToLeft"),
    where="{}",
    holder="BoofCV's model",
)
_CAMERA = """\
{side}:
  pinhole:
    fx: 0.0
    fy: 0.0
    cx: 0.0
    cy: 0.0
    width: {width}
    height: {height}
    skew: 0.0
  model: pinhole_radial_tangential
  radial_tangential:
    radial:
    - 0.0
    - 0.0
    t1: 0.0
    t2: 0.0
"""
_POSE = "model: stereo_camera\nrightToLeft:\n  rotation:\n" + "  - 0.0\n" * 9 + "  x: 0.0\n  y: 0.0\n  z: 0.0\n"


def _read(documents: Documents, hints: Hints) -> StereoRig:
    for side in _TABLE.names:
        with about(side):
            camera = value(documents[0].content, side)
            check_model(camera.get("model", _PINHOLE), (_PINHOLE,))
            if float(numbers(value(camera, "pinhole"), "skew", ())) != 0.0:
                raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
    return _TABLE.read(documents, hints)


def _blank(rig: StereoRig, syntax: Syntax) -> tuple[str]:
    """One file, its keys in BoofCV's order."""
    left, right = (
        _CAMERA.format(side=side, width=camera.size[0], height=camera.size[1])
        for side, camera in zip(_TABLE.names, (rig.left, rig.right), strict=True)
    )
    return (f"# Intrinsic and extrinsic parameters for a stereo camera pair\n{left}{_POSE}{right}",)


FORMAT = Format(
    "boofcv",
    "BoofCV's stereo calibration (YAML with left, right, rightToLeft)",
    None,
    lambda document: isinstance(document.content.get("rightToLeft"), Mapping),
    _read,
    syntax=YAML,
    blank=_blank,
    write=_TABLE.write,
)
