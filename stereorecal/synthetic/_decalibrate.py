"""Decalibration: random drift of a rig's extrinsics, as vibration, temperature or a knock would cause."""

import jax
import numpy as np

from stereorecal import InputError
from stereorecal.geometry import StereoRig


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
