"""A rig from the `CameraInfo` of its two cameras, and the `CameraInfo` of a rig."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal import Camera, InputError, StereoRig, UnsupportedModelError, View, view
from stereorecal.geometry import rectifying_rotations
from stereorecal_ros._pairing import SIDES

_PINHOLE = ("plumb_bob", "rational_polynomial", "none", "")
_FISHEYE = ("equidistant", "fisheye")
_SAME_FOCAL = 1e-6  # of the focal length
_DIGITS = 1e-6


@dataclass(frozen=True)
class CameraInfo:
    """The fields of `sensor_msgs/CameraInfo` that a calibration consists of.

    Attributes:
        width, height: of the images, pixels.
        distortion_model: "plumb_bob", "rational_polynomial" or "equidistant".
        d: coefficients, in OpenCV's order.
        k: (9) camera matrix, row by row, pixels.
        r: (9) rotation from the camera's frame to the rectified one.
        p: (12) projection matrix of the rectified camera; of the right one, p[3] is minus the focal length times the
            baseline, in pixels times metres.
    """

    width: int
    height: int
    distortion_model: str
    d: tuple[float, ...]
    k: tuple[float, ...]
    r: tuple[float, ...]
    p: tuple[float, ...]

    @staticmethod
    def of(message: Any) -> "CameraInfo":
        """The fields of a message.

        Raises:
            InputError: if it is about images that are binned, or cut out of larger ones.
        """
        width, height, roi = message.width, message.height, message.roi
        binned = max(message.binning_x, message.binning_y) > 1
        cut = roi.width not in (0, width) or roi.height not in (0, height) or roi.x_offset or roi.y_offset
        if binned or cut:
            raise InputError("camera_info: images that are binned or cut are not supported; publish whole ones.")
        numbers = (tuple(float(value) for value in values) for values in (message.d, message.k, message.r, message.p))
        return CameraInfo(int(width), int(height), str(message.distortion_model), *numbers)

    def is_like(self, other: "CameraInfo") -> bool:
        """Whether it says the same, but for digits that were not written."""
        one, two = ((*info.d, *info.k, *info.r, *info.p) for info in (self, other))
        same = (self.width, self.height, self.distortion_model) == (other.width, other.height, other.distortion_model)
        return same and len(one) == len(two) and np.allclose(one, two, rtol=_DIGITS, atol=_DIGITS)


def rig_of(left: CameraInfo, right: CameraInfo) -> StereoRig:
    """The rig whose rectification two CameraInfo describe: R = R_right' R_left, T = R_right' (t_right - t_left), in
    metres, where P = K [I | t].

    Raises:
        InputError: if they are not calibrated, have no baseline, are exchanged, or one is above the other.
        UnsupportedModelError: if the model of a lens is not known.
    """
    cameras, rotations, places = [], [], []
    for side, info in zip(SIDES, (left, right), strict=True):
        if not any(info.k):
            raise InputError(f"{side}/camera_info: the camera is not calibrated (K is 0); calibrate it first.")
        projection = np.reshape(info.p, (3, 4))
        if not min(np.diag(projection)) > 0.0 or np.any(np.tril(projection, -1)):
            raise InputError(f"{side}/camera_info: there is no projection matrix P; calibrate the two as stereo.")
        cameras.append(_camera(info, side))
        rotations.append(np.reshape(info.r, (3, 3)))
        places.append(np.linalg.solve(projection[:, :3], projection[:, 3]))
    shift = places[1] - places[0]
    if not np.any(shift):
        raise InputError(
            "camera_info: P has no baseline (its fourth column is the same in both); calibrate the two as stereo."
        )
    to_left, to_right = rotations
    return side_by_side(StereoRig.from_rotation(cameras[0], cameras[1], to_right.T @ to_left, to_right.T @ shift))


def side_by_side(rig: StereoRig) -> StereoRig:
    """The rig, of whose images the rectified ones are published.

    Raises:
        InputError: if its images would have to be turned.
    """
    if rig.side_by_side() is not rig:
        raise InputError(
            "camera_info: one camera is above the other (the baseline is in P[7]), or upside down; images that must be "
            "turned are not supported here, use cameras side by side."
        )
    return rig


def view_of(left: CameraInfo, right: CameraInfo) -> View | None:
    """The rectified cameras that two CameraInfo describe; None where they are none that rows and depth can go by: of
    two focal lengths or centre rows."""
    (fx, row), (other, other_row) = ((info.p[0], info.p[6]) for info in (left, right))
    focals = (fx, left.p[5], other, right.p[5])
    if not min(focals) > 0.0 or np.ptp(focals) > _SAME_FOCAL * fx or abs(row - other_row) > _SAME_FOCAL * fx:
        return None
    return View((left.width, left.height), fx, left.p[2], right.p[2], row)


def corrected(rig: StereoRig, shown: View | None = None) -> tuple[CameraInfo, CameraInfo]:
    """What to publish for a rig: rectified with R and P of both cameras, rows are aligned, and a disparity of d pixels
    is a depth of -P_right[3] / (d - (cx - cx')) metres.

    Args:
        shown: the rectified cameras; default `sr.view(rig, projection="pinhole")`.

    Raises:
        UnsupportedModelError: if ROS has no such model of a lens.
        InputError: if the view is no pinhole, which P holds.
    """
    shown = view(rig, projection="pinhole") if shown is None else shown
    if shown.projection != "pinhole":
        raise InputError(
            f"a CameraInfo holds pinhole views, not {shown.projection} ones; give sr.view(rig, projection='pinhole')."
        )
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    matrices, shifts = (shown.matrix_left, shown.matrix_right), (0.0, -float(shown.focal) * float(rig.baseline))
    infos = []
    for camera, rotation, matrix, shift in zip((rig.left, rig.right), rotations, matrices, shifts, strict=True):
        (model, d), k = _lens(camera), _row_by_row(camera.matrix)
        projection = np.column_stack([matrix, [shift, 0.0, 0.0]])
        infos.append(CameraInfo(*camera.size, model, d, k, _row_by_row(rotation), _row_by_row(projection)))
    return infos[0], infos[1]


def is_like(one: StereoRig, other: StereoRig) -> bool:
    """Whether two calibrations are one, which may have been written with some digits less."""
    return all(a.is_like(b) for a, b in zip(corrected(one), corrected(other), strict=True))


def _camera(info: CameraInfo, side: str) -> Camera:
    if info.distortion_model not in (*_PINHOLE, *_FISHEYE):
        raise UnsupportedModelError(
            f"{side}/camera_info: the distortion model {info.distortion_model!r} is not supported; use plumb_bob, "
            "rational_polynomial or equidistant."
        )
    model = "equidistant" if info.distortion_model in _FISHEYE else Camera.model
    try:
        return Camera((info.width, info.height), np.reshape(info.k, (3, 3)), np.array(info.d), model=model)
    except InputError as error:
        raise type(error)(f"{side}/camera_info: {error}") from error


def _lens(camera: Camera) -> tuple[str, tuple[float, ...]]:
    d = np.asarray(camera.distortion, float).tolist()
    if camera.model == "equidistant":
        return "equidistant", tuple(d)
    if camera.model != Camera.model:
        raise UnsupportedModelError(
            f"ROS has no lens of the model {camera.model!r}; calibrate as plumb_bob, rational_polynomial or "
            "equidistant."
        )
    return ("plumb_bob" if len(d) <= 5 else "rational_polynomial"), tuple(d + [0.0] * (5 - len(d)))


def _row_by_row(values: Any) -> tuple[float, ...]:
    numbers: Sequence[float] = np.asarray(values, float).reshape(-1).tolist()
    return tuple(numbers)
