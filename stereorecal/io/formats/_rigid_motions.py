"""Rigid motions as 4x4 matrices."""

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import AS_IN_FILE, Camera, StereoRig, extrinsics_of

Pose = Float[np.ndarray, "4 4"]


def pose(rotation: Mat3, translation: Vec3) -> Pose:
    """The rigid motion x -> R x + T as a matrix (4, 4)."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation, translation
    return made


def inverse(motion: Pose) -> Pose:
    """The inverse of a rigid motion (4, 4)."""
    try:
        return np.linalg.inv(motion)
    except np.linalg.LinAlgError:
        raise InputError("R is not a rotation (orthonormal, determinant +1); correct the calibration.") from None


def left_to_right(rig: StereoRig) -> Pose:
    """The pose that takes points of the left camera's frame to the right one's."""
    return pose(np.asarray(rig.rotation), np.asarray(rig.translation))


def rig_of(left: Camera, right: Camera, motion: Pose) -> StereoRig:
    """The rig of the first and the second camera of a file, and the motion from the first frame to the second one:
    `_camera_choice.py` says which is the left one."""
    return StereoRig(left, right, extrinsics_of(motion[:3, :3], motion[:3, 3]), source=AS_IN_FILE)
