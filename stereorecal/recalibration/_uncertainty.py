"""How well the solution is known, in the units in which people read it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.objectives import FREE_AXES, Chart, SearchBox

_NORMAL_95 = 1.96
_OBSERVED = 0.5  # of the prior's standard deviation; above it, the answer is mostly the prior


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of the five free parameters: pitch, yaw, roll in degrees, y, z in percent of the baseline.

    Attributes:
        covariance: (5, 5), the prior on the drift included.
        observed: (5,) which parameters the data determine; the others stay near the initial calibration.
    """

    covariance: Float[np.ndarray, "5 5"]
    observed: Bool[np.ndarray, "5"]

    @property
    def interval(self) -> Float[np.ndarray, "5"]:
        """Half widths of the 95 % intervals."""
        return _NORMAL_95 * np.sqrt(np.diag(self.covariance))

    @property
    def unwidened(self) -> Float[np.ndarray, "5"]:
        return self.interval

    @property
    def unobserved(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not determine."""
        return tuple(name for name, seen in zip(FREE_AXES, self.observed, strict=True) if not seen)


def uncertainty(covariance: Float[np.ndarray, "n n"], box: SearchBox) -> Uncertainty:
    """The uncertainty of a solution whose covariance is `covariance`, in half widths of the box."""
    unit = reading_units(box.chart)
    observed = np.sqrt(np.diag(covariance)) < _OBSERVED * box.prior
    return Uncertainty(covariance * unit[:, None] * unit, observed)


def reading_units(chart: Chart) -> Float[np.ndarray, "n"]:
    """One half width of the box: in degrees, or in percent of the baseline."""
    baseline = float(np.linalg.norm(chart.centre[3:]))
    return np.array(
        [np.degrees(chart.half_width[i]) if i < 3 else 100 * chart.half_width[i] / baseline for i in chart.free]
    )
