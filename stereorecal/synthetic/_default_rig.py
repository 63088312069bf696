"""The default rig of synthetic scenes, and random drift of a rig, as vibration, temperature or a knock would cause."""

import jax
import numpy as np

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig


def default_rig() -> StereoRig:
    """A 640x480 rig with a baseline of about 356 mm, radial distortion, and extrinsics that are not ideal.

    The cameras differ slightly from each other, and the extrinsics are a few tenths of a degree and a few millimetres
    off the ideal rig, so that a bias of a strategy towards the ideal rig shows as an error. All numbers are invented; a
    camera sees about 56 degrees across.
    """
    left = Camera(
        (640, 480),
        np.array([[601.3, 0.0, 322.4], [0.0, 600.7, 236.8], [0.0, 0.0, 1.0]]),
        np.array([-0.251, 0.092, 0.0004, -0.0003, -0.012]),
    )
    right = Camera(
        (640, 480),
        np.array([[598.6, 0.0, 316.1], [0.0, 598.9, 243.5], [0.0, 0.0, 1.0]]),
        np.array([-0.246, 0.085, -0.0002, 0.0005, -0.009]),
    )
    angles = np.radians([0.31, -0.44, 0.27])
    return StereoRig(left, right, np.concatenate([angles, [-0.356, 0.0041, -0.0036]]))


def decalibrate(rig: StereoRig, key: jax.Array, degrees: float, baseline_fraction: float) -> StereoRig:
    """The rig with a random drift added to its extrinsics, float64.

    Pitch, yaw, roll, y and z drift independently, each uniformly within its limit to either side; x does not drift.

    Args:
        key: a `jax.random.key`.
        degrees: largest drift of each angle, in degrees.
        baseline_fraction: largest drift of y and of z, as a fraction of the rig's baseline.

    Raises:
        InputError: if a limit is negative or not finite.
    """
    for name, limit in (("degrees", degrees), ("baseline_fraction", baseline_fraction)):
        if not (np.isfinite(limit) and limit >= 0.0):
            raise InputError(f"{name} is {limit}; give a drift limit that is finite and not negative.")
    shift = baseline_fraction * rig.baseline
    limits = np.array([*[np.radians(degrees)] * 3, 0.0, shift, shift])
    draw = np.asarray(jax.random.uniform(key, (6,), minval=-1.0, maxval=1.0), np.float64)
    return rig.with_extrinsics(np.asarray(rig.extrinsics, np.float64) + limits * draw)
