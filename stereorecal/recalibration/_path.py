"""The way that a repair took."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.objectives import Chart, Reach, chart_around
from stereorecal.recalibration._schedule import ScoreKind
from stereorecal.recalibration._stages import WIDER, StageRun


@dataclass(frozen=True, eq=False)
class Waypoint:
    """Where a repair stood.

    Attributes:
        cost: units spent by then (one unit: one matcher run on one full-size frame).
        extrinsics: (6,) pitch, yaw, roll [rad], x, y, z [m].
    """

    cost: float
    extrinsics: Float[np.ndarray, "6"]


def path_of(initial: StereoRig, reach: Reach, surveyed: float, stages: Sequence[StageRun]) -> tuple[Waypoint, ...]:
    """Where a repair began, where each stage began and ended, and each new best of the stages on the count.

    Args:
        surveyed: units that the survey took, before the first stage.
    """
    narrow = chart_around(initial, reach)
    wide = replace(narrow, half_width=WIDER * narrow.half_width)
    spent, found = surveyed, [Waypoint(0.0, np.asarray(initial.extrinsics))]
    for stage in stages:
        found.append(Waypoint(spent, np.asarray(wide.extrinsics(stage.start))))
        if stage.stage.score is ScoreKind.COUNT:
            found += _climb(stage, narrow, spent)
        spent += stage.cost
        found.append(Waypoint(spent, np.asarray(wide.extrinsics(stage.best))))
    moves = [after for before, after in pairwise(found) if np.any(before.extrinsics != after.extrinsics)]
    return (found[0], *moves)


def _climb(stage: StageRun, chart: Chart, spent: float) -> Iterator[Waypoint]:
    """Each new best among the points that were evaluated; strategies that work inside JAX evaluate none."""
    trace = stage.runs[0].trace
    best = stage.runs[0].start_value
    for point, value, cost in zip(trace.points, trace.values, trace.cost, strict=True):
        if value > best:
            best = value
            yield Waypoint(spent + float(cost), np.asarray(chart.extrinsics(point)))
