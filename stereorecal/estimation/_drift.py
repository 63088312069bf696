"""The drift since the calibration: one event of unknown size, and rarer ones that turn one axis alone.

Pitch and roll, which rows tell for sure, say how far yaw, which they do not, has probably moved.
"""

from functools import cache

import numpy as np
from jaxtyping import Float

from stereorecal.objectives import ROTATION

SIZES = (
    0.002,
    0.02,
    0.05,
    0.1,
    0.2,
    0.5,
    1.0,
    2.0,
    4.0,
)  # degrees, of the angles; the first is none
_SHIFT = 0.6  # y and z as a share of the baseline, per radian
_ALONE = 0.02  # probability of a drift that turns one axis more than the others, of each axis
_LEAST_ALONE = 0.1  # degrees


@cache
def drift_sizes() -> tuple[Float[np.ndarray, "k 5"], Float[np.ndarray, "k"]]:
    """Standard deviations of pitch, yaw, roll [degrees], y and z [% of the baseline] for each kind of drift, and the
    probability of each before any image is seen."""
    shift = 100.0 * _SHIFT * np.pi / 180.0
    together = [[size, size, size, shift * size, shift * size] for size in SIZES]
    alone = []
    for axis in range(len(ROTATION)):
        for size, row in zip(SIZES, together, strict=True):
            for larger in SIZES:
                if larger >= _LEAST_ALONE and larger > 2.0 * size:
                    alone.append([larger if index == axis else value for index, value in enumerate(row)])
    share = len(ROTATION) * _ALONE
    weights = np.r_[np.full(len(together), (1.0 - share) / len(together)), np.full(len(alone), share / len(alone))]
    return np.array([*together, *alone]), weights
