"""What the worker process is asked to do with its state."""

import numpy as np

from stereorecal.online import Event, Kind, State, freeze, rollback
from stereorecal_ros._applied import Offset

Outcome = tuple[State, tuple[Event, ...]]


def frozen(state: State, frozen: bool) -> Outcome:
    """Whether anything is looked for and switched."""
    return freeze(state, frozen), ()


def returned(state: State, offset: Offset) -> Outcome:
    """The calibration that is published again, and frozen, though the state may not know it (any more): it keeps fewer
    than have been published."""
    if not any(np.array_equal(offset, known) for known in state.previous):
        state = state.replace(previous=(*state.previous, offset))
    state = rollback(state, offset)
    return state, (Event(state.frame, Kind.ROLLED_BACK),)
