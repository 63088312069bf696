"""Wrong depth, with its 95 % interval."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart
from stereorecal.recalibration._effects import nearnesses

_STEP = 1e-3  # of the box: some hundredths of a degree


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def farthest(self) -> float:
        """The largest magnitude within the interval."""
        return max(abs(self.low), abs(self.high))


def depth_slopes(used: StereoRig, chart: RigChart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "distances n"]:
    """Derivatives of the true depth over the one that `used` reports, by the point of the chart at which the true rig
    lies."""

    def near(at: Float[np.ndarray, "n"]) -> Float[np.ndarray, "distances"]:
        return nearnesses(used, chart.rig_at(at))

    steps = _STEP * np.eye(len(z))
    return np.stack([(near(z + h) - near(z - h)) / (2 * _STEP) for h in steps], axis=-1)
