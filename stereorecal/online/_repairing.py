"""A repair of what the looks cannot follow: rigs so far off that hardly anything matches."""

from collections.abc import Sequence

from stereorecal._errors import InputError
from stereorecal.online._events import Event, Kind
from stereorecal.online._reading import reading
from stereorecal.online._state import State
from stereorecal.online._switching import after_repair
from stereorecal.recalibration import Reason, Solution, recalibrate
from stereorecal.recordings import Pair

_FAR = 1.5  # pixels: beyond it a window meets other things


def repaired(state: State, pairs: Sequence[Pair]) -> tuple[State, list[Event]]:
    """The state after a repair on pairs that hardly match: a candidate on trial, if it was accepted."""
    events = [Event(state.frame, Kind.REPAIRING, f"from {len(pairs)} pairs")]
    try:
        solution = recalibrate(state.rig, list(pairs), matcher=state.matcher)
    except InputError as error:  # such as: images that are exchanged
        return state, [*events, Event(state.frame, Kind.REJECTED, str(error))]
    if not solution.accepted or solution.covariance is None:
        return state, [*events, _rejected(state, solution)]
    offset = state.offset_of(solution.rig)
    change = dict(zip(state.chart.names, (offset - state.using).tolist(), strict=True))
    knock = Event(state.frame, Kind.KNOCK, "hardly anything matched", {"change": change})
    if state.said is not Kind.KNOCK:
        events.append(knock)
    return after_repair(state.but(said=Kind.KNOCK, ready=0), offset, solution.covariance), events


def too_far(state: State) -> bool:
    """Whether a knock was so large that looks through the calibration in use measure it badly."""
    return reading(state).rows_px.value > _FAR


def _rejected(state: State, solution: Solution) -> Event:
    disagree = solution.reason is Reason.FRAMES_DISAGREE
    kind = Kind.FRAMES_DISAGREE if disagree else Kind.REJECTED
    return Event(state.frame, kind, solution.reason.value)
