"""Drift: what vibration, temperature and a knock do to the extrinsics of a rig."""

import jax
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig


def decalibrate(rig: StereoRig, key: jax.Array, degrees: float, baseline_fraction: float) -> StereoRig:
    """The rig with a random drift added to its extrinsics, float64.

    The drift is uniform and independent on pitch, yaw and roll and on y and z; x stays as it is.

    Args:
        key: a `jax.random.key`.
        degrees: largest drift of each angle.
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
