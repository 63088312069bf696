"""Rotations: exponential, logarithm, the (pitch, yaw, roll) of the paper's extrinsics vector, and what rectifies.

Functions take NumPy arrays (float64, on the host) or JAX arrays (any float type, differentiable, also at the
identity) and answers in kind.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Mat3, Vec3, is_host, namespace, product

# Below this squared angle the Taylor series is exact to float64 rounding for the terms kept.
_SMALL_ANGLE_SQUARED = 1e-8
_TINY = 1e-30  # a complex step


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
    xp, between = namespace(a, b), product(a.T, b)
    return xp.arctan2(xp.sqrt(xp.sum((between - between.T) ** 2) / 8.0), 0.5 * (xp.trace(between) - 1.0))


def rectifying_rotations(rotation: Mat3, translation: Vec3) -> tuple[Mat3, Mat3]:
    """R1, R2 (3, 3): left and right camera frame to the rectified frame, as `cv2.stereoRectify`'s.

    Each camera takes half of the rotation between them (Bouguet's method), then both turn by the smallest rotation
    that lays the baseline along x. Only the direction of `translation` matters.
    """
    xp = namespace(rotation, translation)
    half = rotation_from_vector(-0.5 * vector_from_rotation(rotation))
    baseline = product(half, translation)
    baseline = baseline / xp.sqrt(xp.sum(baseline * baseline))
    along_x = rotation_between(baseline, xp.asarray([-1.0, 0.0, 0.0], dtype=baseline.dtype))
    return product(along_x, half.T), product(along_x, half)


def rectifying_slopes(
    rotation: Float[np.ndarray, "3 3"],
    translation: Float[np.ndarray, "3"],
    by_rotation: Float[np.ndarray, "m 3 3"],
    by_translation: Float[np.ndarray, "m 3"],
) -> Float[np.ndarray, "m 2 3 3"]:
    """Derivatives of `rectifying_rotations`, left and right, where R and T move so.

    Of R with angle a about n, the antisymmetric part K is sin(a) [n] and the trace 1 + 2 cos(a), so half of it back is
    an algebraic function of R, and complex steps (Squire & Trapp 1998) are exact.
    """
    rotation, translation = rotation + _TINY * 1j * by_rotation, translation + _TINY * 1j * by_translation
    back, identity = 0.5 * (rotation - rotation.swapaxes(1, 2)), np.eye(3)
    cosine = 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0)
    of_half = np.sqrt(0.5 * (1.0 + cosine))[:, None, None]
    half = identity - back / (2.0 * of_half) + back @ back / (4.0 * of_half**2 * (1.0 + of_half))
    baseline = (half @ translation[..., None])[..., 0]
    baseline = baseline / np.sqrt((baseline * baseline).sum(axis=1))[:, None]
    turn = np.zeros_like(rotation)
    turn[:, 1:, 0], turn[:, 0, 1:] = baseline[:, 1:], -baseline[:, 1:]
    along_x = identity + turn + turn @ turn / (1.0 - baseline[:, :1, None])
    return np.imag(np.stack([along_x @ half.swapaxes(1, 2), along_x @ half], axis=1)) / _TINY
