"""Cameras and poses as COLMAP has them."""

import numpy as np
import pycolmap
from jaxtyping import Float

from stereorecal.geometry import Camera, euler_from_rotation, rotation_from_euler

# COLMAP's models by ours, and by how many coefficients they take at most, in OpenCV's order.
_MODELS = {"radtan": {0: "PINHOLE", 4: "OPENCV", 8: "FULL_OPENCV"}, "equidistant": {4: "OPENCV_FISHEYE"}}


def colmap_camera(camera: Camera, number: int) -> pycolmap.Camera | None:
    """The camera in COLMAP's terms, where the centre of the first pixel is (0.5, 0.5); None if it has no such model."""
    coefficients = np.trim_zeros(np.asarray(camera.distortion, float), "b")
    fitting = [(most, name) for most, name in _MODELS.get(camera.model, {}).items() if len(coefficients) <= most]
    if not fitting:
        return None
    most, name = min(fitting)
    matrix, (width, height) = np.asarray(camera.matrix, float), camera.size
    made = pycolmap.Camera.create_from_model_name(number, name, matrix[0, 0], width, height)
    pinhole = [matrix[0, 0], matrix[1, 1], matrix[0, 2] + 0.5, matrix[1, 2] + 0.5]
    made.params = [*pinhole, *coefficients, *[0.0] * (most - len(coefficients))]
    made.has_prior_focal_length = True
    return made


def colmap_pose(extrinsics: Float[np.ndarray, "6"]) -> pycolmap.Rigid3d:
    """The right camera from the left one."""
    return pycolmap.Rigid3d(pycolmap.Rotation3d(rotation_from_euler(extrinsics[:3])), np.array(extrinsics[3:], float))


def extrinsics_of(pose: pycolmap.Rigid3d, x: float) -> Float[np.ndarray, "6"]:
    """Pitch, yaw, roll [rad], x, y, z [m] of the right camera's pose, scaled to `x`: images do not show a scale."""
    translation = np.asarray(pose.translation)
    return np.concatenate([euler_from_rotation(pose.rotation.matrix()), translation * (x / translation[0])])
