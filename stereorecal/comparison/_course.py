"""How a trial went: scores and errors over what was spent."""

import numpy as np

from stereorecal.geometry import StereoRig, angle_between, axis_errors
from stereorecal.recalibration import Solution


def course_of(reference: StereoRig, solution: Solution, *, one_score: bool) -> dict[str, list]:
    """See `Trial.course`.

    Args:
        one_score: whether all of the schedule has the same score.
    """
    steps = solution.path
    rigs = [solution.initial.with_extrinsics(step.extrinsics) for step in steps]
    cost = [float(step.cost) for step in steps]
    return {
        "cost": cost,
        "rotation_error_deg": [float(np.degrees(angle_between(rig.rotation, reference.rotation))) for rig in rigs],
        "axes_deg": [list(axis_errors(rig, reference).rotation_deg.values()) for rig in rigs],
        "score": [_best_at(solution, spent) for spent in cost] if one_score else [None] * len(cost),
    }


def _best_at(solution: Solution, cost: float) -> float | None:
    runs = [run for stage in solution.stages for run in stage.runs]
    if not runs:
        return None
    best = runs[-1].trace.best_within(cost)
    start = float(runs[-1].start_value)
    return start if best is None else max(start, best)
