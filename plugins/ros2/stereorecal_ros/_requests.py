"""What the worker process is asked to do with its state."""

from stereorecal import InputError
from stereorecal.online import Event, Kind, State, freeze, rollback
from stereorecal_ros._applied import Offset

Outcome = tuple[State, tuple[Event, ...]]


def frozen(state: State, frozen: bool) -> Outcome:
    """Whether anything is looked for and switched."""
    return freeze(state, frozen), ()


def returned(state: State, offset: Offset) -> Outcome:
    """The calibration that is published again, and frozen; frozen alone, if it was in use too long ago."""
    try:
        state = rollback(state, offset)
    except InputError:
        state = freeze(state)
    return state, (Event(state.frame, Kind.ROLLED_BACK),)
