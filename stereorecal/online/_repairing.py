"""A repair of what the looks cannot follow: rigs so far off that hardly anything matches; and a recalibration on
request, in place of waiting until looks ask for one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereorecal._errors import InputError
from stereorecal.objectives import EXTRINSICS, Parameters, Reach
from stereorecal.online._events import Event, Kind
from stereorecal.online._filter_posterior import prior_now
from stereorecal.online._reading import reading
from stereorecal.online._state import Job, State
from stereorecal.online._switching import after_repair, calibration_data, switched, told_by
from stereorecal.recalibration import (
    Case,
    Progress,
    Reason,
    Schedule,
    Solution,
    next_slice,
    recalibrate as recalibrated,
)
from stereorecal.recordings import Pair, Pairs, check_pairs
from stereorecal.scoring import pyramid

_BLIND = 1.5  # pixels of row error: beyond, windows show other things


def begun(state: State, pairs: Sequence[Pair]) -> tuple[State, list[Event]]:
    """The state with a repair under way, on pairs that hardly match."""
    event = Event(state.frame, Kind.REPAIRING, f"from {len(pairs)} pairs")
    return state.replace(job=Job(tuple(pairs), np.asarray(state.rig.extrinsics, float))), [event]


def continued(state: State) -> tuple[State, list[Event]]:
    """The state after one more slice of its repair; after the last one a candidate on trial, if it was accepted."""
    job, matcher = state.job, state.matcher
    assert job is not None
    assert matcher is not None
    rig = state.rig
    try:
        case = Case(pyramid(rig, job.pairs, state.config.view), matcher, Reach(), Parameters(), prior_now(state))
        ended = next_slice(case, Schedule.default(), Progress(rig.with_extrinsics(job.at), job.done))
    except InputError as error:  # such as: images that are exchanged
        return state.replace(job=None), [Event(state.frame, Kind.REJECTED, str(error))]
    if isinstance(ended, Progress):
        return state.replace(job=replace(job, at=np.asarray(ended.rig.extrinsics, float), done=ended.done)), []
    return _after_solution(state.replace(job=None), ended)


def _after_solution(state: State, solution: Solution) -> tuple[State, list[Event]]:
    if not solution.accepted or solution.estimate is None:
        return state, [_rejected(state, solution)]
    offset = state.offset_of(solution.rig)
    change = dict(zip(state.chart.names, (offset - state.using).tolist(), strict=True))
    knock = Event(state.frame, Kind.KNOCK, "almost nothing matched", {"change": change})
    events = [] if state.reported is Kind.KNOCK else [knock]
    return after_repair(state.replace(reported=Kind.KNOCK, ready=0), offset, solution.estimate), events


def too_far(state: State) -> bool:
    """Whether a knock was so large that looks through the calibration in use measure it badly."""
    return reading(state).rows_px.value > _BLIND


def _rejected(state: State, solution: Solution) -> Event:
    disagree = solution.reason is Reason.FRAMES_DISAGREE
    kind = Kind.FRAMES_DISAGREE if disagree else Kind.REJECTED
    return Event(state.frame, kind, solution.reason.value)


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
