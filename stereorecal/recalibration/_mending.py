"""What would mend a calibration, how sure that is, and what is wrong for those who go on without."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart
from stereorecal.recalibration._consequences import Consequences, Interval, consequences
from stereorecal.recalibration._evidence import Evidence
from stereorecal.recalibration._uncertainty import uncertainty


@dataclass(frozen=True, eq=False)
class Mending:
    """The change of the extrinsics that one look asks for.

    Attributes:
        axes: by name: pitch, yaw, roll in degrees, y and z in percent of the baseline, each with its 95 % interval.
        consequences: of leaving the calibration as it is.
        significance: of the whole change against none, in standard errors (Wald's chi-square on as many degrees of
            freedom as axes, as the normal deviate that is as rare).
        row_error: that would remain, pixels at full size, each tile judged by a solution that has not seen it.
    """

    axes: Mapping[str, Interval]
    consequences: Consequences
    significance: float
    row_error: float

    @property
    def named(self) -> tuple[str, ...]:
        """The axes whose interval leaves out zero; where only their sum does, the surest one."""
        sure = {name: abs(axis.value) / max(axis.high - axis.value, 1e-12) for name, axis in self.axes.items()}
        return tuple(name for name, ratio in sure.items() if ratio > 1.0) or (max(sure, key=sure.__getitem__),)


def mending(used: StereoRig, chart: RigChart, facts: Evidence, remaining: float) -> Mending:
    """The mending that the evidence asks for.

    Args:
        used: the centre of the chart.
        remaining: row error that it would leave.
    """
    covariance = facts.covariance()
    values, widths = chart.units * facts.z, uncertainty(covariance, 0.0 * covariance, chart).interval
    return Mending(
        axes={
            name: Interval(value, value - width, value + width)
            for name, value, width in zip(chart.names, values.tolist(), widths.tolist(), strict=True)
        },
        consequences=consequences(used, chart, facts, covariance),
        significance=wald(facts.z, covariance),
        row_error=remaining,
    )


def wald(z: Float[np.ndarray, "n"], covariance: Float[np.ndarray, "n n"]) -> float:
    """How many standard errors z is from zero: the chi-square zᵀ C⁻¹ z as a normal deviate, by the cube root of
    Wilson & Hilferty (1931), which knows no overflow."""
    squared, tenth = float(z @ np.linalg.solve(covariance, z)), 2.0 / (9.0 * len(z))
    return float(((squared / len(z)) ** (1.0 / 3.0) - (1.0 - tenth)) / np.sqrt(tenth))
