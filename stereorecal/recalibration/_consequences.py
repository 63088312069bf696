"""Wrong depth, with its 95 % interval."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart
from stereorecal.recalibration._effects import DISTANCES, depth_error, nearnesses
from stereorecal.recalibration._uncertainty import NORMAL_95

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


def depth_intervals(
    used: StereoRig, chart: RigChart, z: Float[np.ndarray, "n"], covariance: Float[np.ndarray, "n n"]
) -> Mapping[int, Interval]:
    """The error of depth in percent of `used`, if the true rig lies around the point z of the chart."""
    slopes = depth_slopes(used, chart, z)
    here, width = nearnesses(used, chart.rig_at(z)), NORMAL_95 * deviations(slopes, covariance)
    ends = np.stack([here, here + width, here - width], axis=-1)
    return {
        distance: Interval(*map(depth_error, three)) for distance, three in zip(DISTANCES, ends.tolist(), strict=True)
    }


def depth_slopes(used: StereoRig, chart: RigChart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "distances n"]:
    """Derivatives of the true depth over the one that `used` reports, by the point of the chart at which the true rig
    lies."""

    def near(at: Float[np.ndarray, "n"]) -> Float[np.ndarray, "distances"]:
        return nearnesses(used, chart.rig_at(at))

    steps = _STEP * np.eye(len(z))
    return np.stack([(near(z + h) - near(z - h)) / (2 * _STEP) for h in steps], axis=-1)


def deviations(slopes: Float[np.ndarray, "p n"], covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "p"]:
    """Standard deviations of what is linear in the solution, with these slopes."""
    return np.sqrt(np.maximum(np.sum(slopes @ covariance * slopes, axis=-1), 0.0))
