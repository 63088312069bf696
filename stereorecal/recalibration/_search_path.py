"""The way that a repair took."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._stages import StageRun


@dataclass(frozen=True, eq=False)
class Waypoint:
    """Where a repair stood.

    Attributes:
        cost: units spent by then (one unit: one matcher run on one full-size frame).
        extrinsics: (6,) pitch, yaw, roll [rad], x, y, z [m].
    """

    cost: float
    extrinsics: Float[np.ndarray, "6"]


def path_of(initial: StereoRig, before: float, stages: Sequence[StageRun]) -> tuple[Waypoint, ...]:
    """Where a repair began, where each stage began and ended, and each new best of the stages on the count.

    Args:
        before: units spent before the first stage, on the survey and on choosing a start.
    """
    spent, found = before, [Waypoint(0.0, np.asarray(initial.extrinsics))]
    for stage in stages:
        found.append(Waypoint(spent, stage.start))
        found += [Waypoint(spent + float(row[0]), row[1:]) for row in stage.path]
        spent += stage.cost
        found.append(Waypoint(spent, stage.end_extrinsics))
        spent += stage.survey_cost
    moves = [after for before, after in pairwise(found) if np.any(before.extrinsics != after.extrinsics)]
    return (found[0], *moves)
