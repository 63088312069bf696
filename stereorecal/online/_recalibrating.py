"""A recalibration on request, in place of waiting until looks ask for one."""

from stereorecal._errors import InputError
from stereorecal.objectives import EXTRINSICS
from stereorecal.online._events import Event, Kind
from stereorecal.online._filter_posterior import prior_now
from stereorecal.online._state import State
from stereorecal.online._switching import calibration_data, switched, told_by
from stereorecal.recalibration import recalibrate as recalibrated
from stereorecal.recordings import Pairs, check_pairs


def recalibrate(state: State, pairs: Pairs) -> tuple[State, tuple[Event, ...]]:
    """What `sr.recalibrate` finds of the extrinsics in use, which takes their place if the decision accepts it; else
    the state stays as it is. A state that is frozen stays so.

    Args:
        pairs: the last ones, of different views of the scene; used jointly.

    Returns:
        The state, and RECALIBRATED, or REJECTED with the reason.
    """
    try:
        pairs = check_pairs(state.rig, pairs)
        solution = recalibrated(
            state.rig,
            pairs,
            matcher=state.config.matcher,
            view=state.config.view,
            motion=False,
            free=EXTRINSICS,
            prior=prior_now(state),
        )
    except InputError as error:
        return state, (Event(state.frame, Kind.REJECTED, str(error)),)
    if not solution.accepted or solution.estimate is None:
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
    state = told_by(state, solution.estimate).replace(outlier=None, outliers_in_a_row=0, reported=None)
    state = switched(state, offset)
    return state, (Event(state.frame, Kind.RECALIBRATED, "", facts),)
