"""The correction that images ask for, and what is wrong for those who go on without."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stereorecal.decision import Decision
from stereorecal.estimation import Estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.recalibration._expected import Interval, depth_error_intervals
from stereorecal.recalibration._uncertainty import half_widths


@dataclass(frozen=True, eq=False)
class Correction:
    """The change of the extrinsics that one look at the images asks for.

    Attributes:
        estimate: of the rig that the images show.
        decision: whether the change is worth it.
        row_error: that would remain, pixels at full size: mean over the tiles of a tile's median.
    """

    estimate: Estimate
    decision: Decision
    row_error: float

    @cached_property
    def axes(self) -> dict[str, Interval]:
        """By name: pitch, yaw, roll in degrees, y and z in percent of the baseline, each with its 95 % interval."""
        theta, names = self.decision.theta, self.estimate.names
        widths = half_widths(self.estimate.posterior.covariance, self.estimate.theta - theta)
        each = zip(names, theta.tolist(), widths.tolist(), strict=True)
        return {name: Interval(value, value - wide, value + wide) for name, value, wide in each if name in EXTRINSICS}

    @property
    def rows_px(self) -> Interval:
        """Row error under the calibration, where images show something, pixels at full size."""
        return Interval(*self.decision.rows_px[0].tolist())

    @cached_property
    def depth_percent(self) -> Mapping[int, Interval]:
        """The calibration's error of depth at 5, 10, 30 and 100 baselines; positive: too far, infinite: beyond
        infinity."""
        return depth_error_intervals(self.estimate, np.zeros(len(self.estimate.names)))

    @cached_property
    def main_axes(self) -> tuple[str, ...]:
        """Those whose change alone moves rows or depth by what is noticed, what moves most first; if none does, the
        first of them."""
        effects = {
            name: self.estimate.effect(np.where(np.arange(len(self.estimate.names)) == index, self.decision.theta, 0.0))
            for index, name in enumerate(self.estimate.names)
            if name in EXTRINSICS
        }
        most = sorted(effects, key=lambda name: -effects[name])
        return tuple(name for name in most if effects[name] > 1.0) or tuple(most[:1])
