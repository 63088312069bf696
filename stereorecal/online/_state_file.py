"""A file that holds the newest state of a process, as it goes on."""

import math
import time
from dataclasses import dataclass
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.online._events import Event, Kind
from stereorecal.online._saving import save
from stereorecal.online._state import State


@dataclass
class StateFile:
    """Where states are saved. A place that cannot be written to, such as a full disk, is told once, and tried again.

    Attributes:
        path: of the file; None saves nothing.
        every: seconds between two attempts, at least.
        written: the state that the file holds, or that need not be written.
    """

    path: str | Path | None
    every: float
    written: State
    _tried: float = -math.inf
    _failed: bool = False

    def keep(self, state: State, *, now: bool) -> tuple[Event, ...]:
        """Save a state if that is due, or `now`; returns what is to be told of it."""
        if self.path is None or state is self.written or not (now or time.monotonic() - self._tried >= self.every):
            return ()
        self._tried, failed = time.monotonic(), self._failed
        try:
            save(state, self.path)
        except InputError as error:
            self._failed = True
            return () if failed else (Event(state.frame, Kind.NOT_SAVED, str(error)),)
        self.written, self._failed = state, False
        return (Event(state.frame, Kind.SAVED),) if failed else ()
