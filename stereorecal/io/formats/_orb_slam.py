"""Settings of ORB-SLAM: Camera1.fx …, Camera2.fx … and Stereo.T_c1_c2 (or Tlr), or rectified images with Camera.bf."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints, inverse, pose, rig_of
from stereorecal.io.formats._numbers import numbers, pinhole_matrix, pixels, scalars, size_of
from stereorecal.io.formats.text._document import Document

_RIGHT_TO_LEFT = ("Stereo.T_c1_c2", "Tlr")
_BASELINES = ("Stereo.b", "Camera.bf")
_LENSES = {"pinhole": ("radtan", ("k1", "k2", "p1", "p2", "k3")), "rectified": ("radtan", ()),
           "kannalabrandt8": ("equidistant", ("k1", "k2", "k3", "k4"))}  # fmt: skip


def _looks(document: Document) -> bool:
    """Whether there are a first camera and a baseline, of no depth camera (whose baseline is none), and not the raw
    cameras' own matrices, LEFT.K, which say more."""
    content = document.content
    depth = any(str(key).endswith("DepthMapFactor") for key in content)
    stereo = {*_RIGHT_TO_LEFT, *_BASELINES} & content.keys()
    return _first(content) is not None and bool(stereo) and not depth and "LEFT.K" not in content


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of stereo settings; T_c1_c2 takes points from the right camera to the left one."""
    content = documents[0].content
    left = _camera(content, _first(content) or "Camera1", hints)
    key = next((key for key in _RIGHT_TO_LEFT if key in content), None)
    if key is None:
        if np.any(left.distortion):
            raise InputError(
                "the images are rectified, by the baseline alone (Camera.bf, Stereo.b), but there are coefficients of "
                "a lens; give the settings with Camera2 and Stereo.T_c1_c2, or the calibration of the raw cameras."
            )
        bf = "Stereo.b" not in content
        baseline = float(numbers(content, _BASELINES[bf], ())) / (float(left.matrix[0, 0]) if bf else 1.0)
        return rig_of(left, left, pose(np.eye(3), np.array([-baseline, 0.0, 0.0])))
    motion = numbers(content, key, (3, 4) if size_of(content, (key,)) == 12 else (4, 4))
    return rig_of(left, _camera(content, "Camera2", hints), inverse(pose(motion[:3, :3], motion[:3, 3])))


def _first(content: Mapping[str, Any]) -> str | None:
    return next((name for name in ("Camera1", "Camera") if f"{name}.fx" in content), None)


def _camera(content: Mapping[str, Any], name: str, hints: Hints) -> Camera:
    kind = str(content.get("Camera.type", "PinHole")).lower()
    if kind not in _LENSES:
        raise UnsupportedModelError(f"the camera type {content['Camera.type']!r} is not supported; calibrate anew.")
    model, names = _LENSES[kind]
    four = scalars(content, [f"{name}.{key}" for key in ("fx", "fy", "cx", "cy")])
    lens = [float(numbers(content, key, ())) if (key := f"{name}.{one}") in content else 0.0 for one in names]
    if "Camera.width" in content:
        size = pixels(content, "Camera.width"), pixels(content, "Camera.height")
    else:
        size = hints.needed_size("the file has no Camera.width")
    with about(name):
        return Camera(size, pinhole_matrix(four), np.array(lens), model=model)


FORMAT = Format(
    "orbslam",
    "stereo settings of ORB-SLAM (Camera1.fx, Stereo.T_c1_c2, Camera.bf)",
    "m",
    _looks,
    _read,
)
