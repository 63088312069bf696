"""Settings of VINS-Fusion: body_T_cam0, body_T_cam1, and the names of two files of cameras beside (camodocal's)."""

from pathlib import Path

from stereorecal._errors import UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, inverse, rig_of
from stereorecal.io.formats._numbers import numbers, value
from stereorecal.io.formats._table import Lens, Table, places
from stereorecal.io.formats.text._document import Document, read_document

_SIZE, _PROJECTION, _DISTORTION = ("image_width", "image_height"), "projection_parameters", "distortion_parameters"
_RADTAN = places(_DISTORTION, "k1 k2 p1 p2")
_CAMERAS = {  # by model_type
    "PINHOLE": Table(_SIZE, places(_PROJECTION, "fx fy cx cy"), {"": Lens(_RADTAN)}),
    "KANNALA_BRANDT": Table(
        _SIZE, places(_PROJECTION, "mu mv u0 v0"), {"": Lens(places(_PROJECTION, "k2 k3 k4 k5"), "equidistant")}
    ),
    "MEI": Table(
        _SIZE, places(_PROJECTION, "gamma1 gamma2 u0 v0"), {"": Lens(("mirror_parameters/xi", *_RADTAN), "omni")}
    ),
}


def _looks(document: Document) -> bool:
    """Whether there is the pose of a camera on a body, and the name of a file of it."""
    return bool({"body_T_cam0", "body_T_cam1"} & document.content.keys()) and "cam0_calib" in document.content


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of VINS' settings and of the files that they name, which lie beside them."""
    content, folder = documents[0].content, Path(documents[0].name).parent
    poses = [numbers(content, f"body_T_cam{side}", (4, 4)) for side in (0, 1)]
    left, right = (_camera(folder / Path(str(value(content, f"cam{side}_calib"))).name) for side in (0, 1))
    return rig_of(left, right, inverse(poses[1]) @ poses[0])


def _camera(path: Path) -> Camera:
    content = read_document(path, if_missing="put it beside the settings, which name it.").content
    with about(path):
        if content.get("model_type") not in _CAMERAS:
            raise UnsupportedModelError(
                f"the model_type {content.get('model_type')!r} is not supported; calibrate as one of "
                f"{', '.join(_CAMERAS)}."
            )
        return _CAMERAS[content["model_type"]].camera(content, "")


FORMAT = Format(
    "vins",
    "settings of VINS-Fusion (body_T_cam0, cam0_calib) beside its two files of cameras",
    "m",
    _looks,
    _read,
)
