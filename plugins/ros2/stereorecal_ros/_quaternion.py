"""A rotation as ROS has it."""

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import vector_from_rotation


def quaternion(rotation: Float[np.ndarray, "3 3"]) -> tuple[float, float, float, float]:
    """x, y, z, w of a rotation matrix; w is 0 or more."""
    vector = np.asarray(vector_from_rotation(rotation), float)
    angle = float(np.linalg.norm(vector))
    x, y, z = (0.5 * np.sinc(0.5 * angle / np.pi) * vector).tolist()
    return x, y, z, float(np.cos(0.5 * angle))
