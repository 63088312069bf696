"""A recalibration on request, in place of waiting until looks ask for one."""

import numpy as np

from stereorecal._errors import InputError
from stereorecal.online._events import Event, Kind
from stereorecal.online._filter import SIZE
from stereorecal.online._state import State
from stereorecal.online._switching import AFTER_REPAIR, calibration_data, switched
from stereorecal.recalibration import recalibrate as recalibrated
from stereorecal.recordings import Pairs, check_pairs


def recalibrate(state: State, pairs: Pairs) -> tuple[State, tuple[Event, ...]]:
    """What `sr.recalibrate` finds from the calibration in use, which takes its place if the decision accepts it; else
    the state stays as it is. A state that is frozen stays so.

    Args:
        pairs: the last ones, of different views of the scene; used jointly.

    Returns:
        The state, and RECALIBRATED, or REJECTED with the reason.
    """
    try:
        options = {"matcher": state.config.matcher, "view": state.config.view, "motion": False}
        pairs = check_pairs(state.rig, pairs)
        solution = recalibrated(state.rig, pairs, **options)
    except InputError as error:
        return state, (Event(state.frame, Kind.REJECTED, str(error)),)
    if not solution.accepted or solution.covariance is None:
        return state, (Event(state.frame, Kind.REJECTED, solution.reason.value),)
    offset, rows = state.offset_of(solution.rig), solution.row_errors
    proof = {
        "by": "recalibration",
        "pairs": len(pairs),
        "reason": solution.reason.name.lower(),
        "row_error_before_px": None if rows is None else float(rows.before),
        "row_error_after_px": None if rows is None else float(rows.after),
    }
    facts = {"old": calibration_data(state, state.using), "new": calibration_data(state, offset), "proof": proof}
    estimate = state.estimate.moved(offset, solution.covariance + np.eye(SIZE) * AFTER_REPAIR**2)
    state = switched(state.standing_at(estimate).replace(outlier=None, outliers_in_a_row=0, reported=None), offset)
    return state, (Event(state.frame, Kind.RECALIBRATED, "", facts),)
