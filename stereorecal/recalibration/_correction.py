"""The correction that images ask for, and what is wrong for those who go on without."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereorecal.decision import Decision
from stereorecal.estimation import Estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.recalibration._interval import Interval


@dataclass(frozen=True, eq=False)
class Correction:
    """The change of the extrinsics that one look at the images asks for.

    Attributes:
        axes: by name: pitch, yaw, roll in degrees, y and z in percent of the baseline, each with its 95 % interval.
        rows_px: row error under the calibration, where images show something, pixels at full size.
        depth_percent: its error of depth at 5, 10, 30 and 100 baselines; positive: too far, infinite: beyond infinity.
        row_error: that would remain, pixels at full size: mean over the tiles of a tile's median.
        decision: whether the change is worth it.
        main_axes: those whose change alone moves rows or depth by what is noticed, what moves most first; if none does,
            the first of them.
    """

    axes: Mapping[str, Interval]
    rows_px: Interval
    depth_percent: Mapping[int, Interval]
    row_error: float
    decision: Decision
    main_axes: tuple[str, ...]


def correction_of(
    estimate: Estimate, decision: Decision, depth: Mapping[int, Interval], row_error: float
) -> Correction:
    """The correction that an estimate asks for.

    Args:
        depth: error of the calibration's.
        row_error: that it would leave.
    """
    widths = 0.5 * (estimate.intervals[:, 1] - estimate.intervals[:, 0])
    middle, low, high = decision.rows_px[0].tolist()
    return Correction(
        axes={
            name: Interval(value, value - width, value + width)
            for name, value, width in zip(estimate.names, decision.theta.tolist(), widths.tolist(), strict=True)
            if name in EXTRINSICS
        },
        rows_px=Interval(middle, low, high),
        depth_percent=depth,
        row_error=row_error,
        decision=decision,
        main_axes=_main_axes(estimate, decision),
    )


def _main_axes(estimate: Estimate, decision: Decision) -> tuple[str, ...]:
    effects = {
        name: estimate.effect(np.where(np.arange(len(estimate.names)) == index, decision.theta, 0.0))
        for index, name in enumerate(estimate.names)
        if name in EXTRINSICS
    }
    most = sorted(effects, key=lambda name: -effects[name])
    return tuple(name for name in most if effects[name] > 1.0) or tuple(most[:1])
