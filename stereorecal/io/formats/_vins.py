"""Settings of VINS-Fusion: body_T_cam0, body_T_cam1, and the names of two files of cameras beside (camodocal's)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints
from stereorecal.io.formats._lens_numbers import pinhole_matrix
from stereorecal.io.formats._numbers import numbers, pixels, value
from stereorecal.io.formats._rigid_motions import inverse, rig_of
from stereorecal.io.formats.text._document import Document, read_document

# For each model_type: the name of ours, its matrix (a map and its keys), and its coefficients (maps and their keys).
_MODELS = {
    "PINHOLE": ("radtan", "projection_parameters", ("fx", "fy", "cx", "cy"),
                (("distortion_parameters", ("k1", "k2", "p1", "p2")),)),
    "KANNALA_BRANDT": ("equidistant", "projection_parameters", ("mu", "mv", "u0", "v0"),
                       (("projection_parameters", ("k2", "k3", "k4", "k5")),)),
    "MEI": ("omni", "projection_parameters", ("gamma1", "gamma2", "u0", "v0"),
            (("mirror_parameters", ("xi",)), ("distortion_parameters", ("k1", "k2", "p1", "p2")))),
}  # fmt: skip


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
        if content.get("model_type") not in _MODELS:
            raise UnsupportedModelError(
                f"the model_type {content.get('model_type')!r} is not supported; calibrate as one of "
                f"{', '.join(_MODELS)}."
            )
        model, matrix, keys, lens = _MODELS[content["model_type"]]
        size = pixels(content, "image_width"), pixels(content, "image_height")
        coefficients = [_scalar(content, name, key) for name, keys_of in lens for key in keys_of]
        four = np.array([_scalar(content, matrix, key) for key in keys])
        return Camera(size, pinhole_matrix(four), np.array(coefficients), model=model)


def _scalar(content: Mapping[str, Any], name: str, key: str) -> float:
    with about(name):
        return float(numbers(value(content, name), key, ()))


FORMAT = Format(
    "vins",
    "settings of VINS-Fusion (body_T_cam0, cam0_calib) beside its two files of cameras",
    "m",
    _looks,
    _read,
)
