"""The correction that images ask for, and what is wrong for those who go on without."""

from collections.abc import Mapping
from dataclasses import dataclass

from stereorecal.decision import Decision
from stereorecal.estimation import Estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.recalibration._interval import Interval


@dataclass(frozen=True, eq=False)
class Correction:
    """The change of the extrinsics that one look at the images asks for.

    Attributes:
        axes: by name: pitch, yaw, roll in degrees, y and z in percent of the baseline, each with its 95 % interval.
        rows_px: rows apart under the calibration, root mean square over the view, pixels at full size.
        depth_percent: its error of depth at 5, 10, 30 and 100 baselines; positive: too far, infinite: beyond infinity.
        row_error: that would remain, pixels at full size: mean over the tiles of a tile's median.
        decision: whether the change is worth it.
    """

    axes: Mapping[str, Interval]
    rows_px: Interval
    depth_percent: Mapping[int, Interval]
    row_error: float
    decision: Decision

    @property
    def significant(self) -> tuple[str, ...]:
        """The axes whose interval leaves out zero; where only their sum does, the surest one."""
        sure = {name: abs(axis.value) / max(axis.high - axis.value, 1e-12) for name, axis in self.axes.items()}
        return tuple(name for name, ratio in sure.items() if ratio > 1.0) or (max(sure, key=sure.__getitem__),)


def correction_of(seen: Estimate, decision: Decision, depth: Mapping[int, Interval], row_error: float) -> Correction:
    """The correction that an estimate asks for.

    Args:
        depth: error of the calibration's.
        row_error: that it would leave.
    """
    widths = 0.5 * (seen.intervals[:, 1] - seen.intervals[:, 0])
    middle, low, high = decision.rows_px[0].tolist()
    return Correction(
        axes={
            name: Interval(value, value - width, value + width)
            for name, value, width in zip(seen.names, decision.theta.tolist(), widths.tolist(), strict=True)
            if name in EXTRINSICS
        },
        rows_px=Interval(middle, low, high),
        depth_percent=depth,
        row_error=row_error,
        decision=decision,
    )
