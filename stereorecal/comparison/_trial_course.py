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
    last = len(steps) - 1
    rigs = [solution.initial.with_extrinsics(step.extrinsics) for step in steps]
    cost = [float(step.cost) for step in steps]
    return {
        "cost": cost,
        "rotation_error_deg": [float(np.degrees(angle_between(rig.rotation, reference.rotation))) for rig in rigs],
        "axes_deg": [list(axis_errors(rig, reference).rotation_deg.values()) for rig in rigs],
        "score": [
            _best_at(solution, spent, ended=step == last) if one_score else None for step, spent in enumerate(cost)
        ],
    }


def _best_at(solution: Solution, cost: float, *, ended: bool) -> float | None:
    """Args: ended: whether the nomination counts, which the core has judged. A strategy that evaluates nothing itself,
    inside JAX or on images, has no other value than that."""
    runs = [run for stage in solution.stages for run in stage.runs]
    if not runs:
        return None
    run = runs[-1]
    values = [run.start_value, run.trace.best_within(cost), run.value if ended else None]
    return float(max(value for value in values if value is not None))
