"""Rectifying rotations, as `cv2.stereoRectify`'s."""

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3, Vec3, namespace, product
from stereorecal.geometry._so3 import rotation_between, rotation_from_vector, vector_from_rotation

_TINY = 1e-30


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
