"""Whether two rigs are the same numbers, but for what writing and reading them rounds, or have the same cameras."""

import numpy as np

from stereorecal.geometry._camera import Camera, same_camera
from stereorecal.geometry._rig import StereoRig

_SAME = 1e-9  # radians, and parts of numbers


def same_rig(one: StereoRig, other: StereoRig) -> bool:
    """Whether all numbers, of images as they were taken, are equal to within 1e-9; coefficients that a lens model lacks
    are 0."""
    one, other = one.as_taken(), other.as_taken()
    turned = np.abs(np.asarray(one.rotation) - other.rotation).max() < _SAME
    shifted = np.allclose(one.translation, other.translation, rtol=0.0, atol=_SAME * float(one.baseline))
    return bool(turned and shifted and _same_camera(one.left, other.left) and _same_camera(one.right, other.right))


def same_cameras(one: StereoRig, other: StereoRig) -> bool:
    """Whether both have the same cameras, to the last digit."""
    return same_camera(one.left, other.left) and same_camera(one.right, other.right)


def _same_camera(one: Camera, other: Camera) -> bool:
    length = max(one.distortion.size, other.distortion.size)
    lenses = [np.concatenate([c.distortion, np.zeros(length - c.distortion.size)]) for c in (one, other)]
    return (
        one.size == other.size
        and one.model == other.model
        and np.allclose(one.matrix, other.matrix, rtol=_SAME)
        and np.allclose(*lenses, rtol=_SAME, atol=1e-15)
    )
