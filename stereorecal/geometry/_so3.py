"""Rotations: exponential, logarithm and the (pitch, yaw, roll) of the paper's extrinsics vector.

Every function takes NumPy arrays (float64, on the host) or JAX arrays (any float type, differentiable, also at the
identity) and answers in kind.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Mat3, Vec3, is_host, namespace, product

# Below this squared angle the Taylor series is exact to float64 rounding for the terms kept.
_SMALL_ANGLE_SQUARED = 1e-8


def _matrix(*rows: list[Any]) -> Mat3:
    """The matrix of these numbers. (`stack` on the host takes longer than all else that a rotation needs.)"""
    return np.array(rows) if is_host(*rows[0]) else jnp.stack([jnp.stack(row) for row in rows])


def cross_matrix(v: Vec3) -> Mat3:
    """The matrix K with `K @ u == cross(v, u)`."""
    xp = namespace(v)
    zero = xp.zeros_like(v[0])
    return _matrix([zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero])


def rotation_from_vector(vector: Vec3) -> Mat3:
    """Exponential map: rotation vector [rad] to rotation matrix (Rodrigues' formula, as `cv2.Rodrigues`)."""
    xp = namespace(vector)
    squared = xp.sum(vector * vector)
    small = squared < _SMALL_ANGLE_SQUARED
    # The unused branch must stay finite for the gradient (double where).
    safe = xp.where(small, 1.0, squared)
    angle = xp.sqrt(safe)
    first = xp.where(small, 1.0 - squared / 6.0, xp.sin(angle) / angle)
    second = xp.where(small, 0.5 - squared / 24.0, 2.0 * xp.sin(0.5 * angle) ** 2 / safe)
    k = cross_matrix(vector)
    return xp.eye(3, dtype=vector.dtype) + first * k + second * product(k, k)


def vector_from_rotation(rotation: Mat3) -> Vec3:
    """Logarithm: rotation matrix to rotation vector [rad], for angles below pi (as `cv2.Rodrigues`)."""
    xp = namespace(rotation)
    sine_axis = 0.5 * xp.stack(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    cosine = 0.5 * (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - 1.0)
    squared = xp.sum(sine_axis * sine_axis)
    small = (squared < _SMALL_ANGLE_SQUARED) & (cosine > 0)
    safe = xp.where(small, 1.0, squared)
    sine = xp.sqrt(safe)
    factor = xp.where(small, 1.0 + squared / 6.0, xp.arctan2(sine, cosine) / sine)
    return factor * sine_axis


def rotation_from_euler(angles: Vec3) -> Mat3:
    """(pitch, yaw, roll) [rad] to `R = Rz(roll) Ry(yaw) Rx(pitch)`."""
    xp = namespace(angles)
    (sx, sy, sz), (cx, cy, cz) = xp.sin(angles), xp.cos(angles)
    return _matrix(
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    )


def euler_slopes(angles: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3 3"]:
    """Derivatives of `rotation_from_euler` by pitch, yaw and roll: each turns about its axis of Rz Ry Rx."""
    rotation, (_, yaw, roll) = rotation_from_euler(angles), angles
    pitching = rotation_from_euler(np.array([0.0, yaw, roll]))[:, 0]
    yawing = rotation_from_euler(np.array([0.0, 0.0, roll]))[:, 1]
    return np.stack([cross_matrix(axis) @ rotation for axis in (pitching, yawing, np.array([0.0, 0.0, 1.0]))])


def euler_from_rotation(rotation: Mat3) -> Vec3:
    """Inverse of `rotation_from_euler`, for yaw within ±90 degrees."""
    xp = namespace(rotation)
    return xp.stack(
        [
            xp.arctan2(rotation[2, 1], rotation[2, 2]),
            xp.arctan2(-rotation[2, 0], xp.hypot(rotation[0, 0], rotation[1, 0])),
            xp.arctan2(rotation[1, 0], rotation[0, 0]),
        ]
    )


def rotation_between(a: Vec3, b: Vec3) -> Mat3:
    """The smallest rotation that turns unit vector `a` onto unit vector `b` (not opposite to it)."""
    xp = namespace(a, b)
    k = cross_matrix(xp.cross(a, b))
    return xp.eye(3, dtype=k.dtype) + k + product(k, k) / (1.0 + xp.sum(a * b))


def angle_between(a: Mat3, b: Mat3) -> float | Float[AnyArray, ""]:
    """Angle [rad] of the rotation that leads from `a` to `b`."""
    xp = namespace(a, b)
    vector = vector_from_rotation(product(a.T, b))
    return xp.sqrt(xp.sum(vector * vector))
