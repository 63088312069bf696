"""Steps in a process of its own, beside a capture loop that must not wait."""

import math
import multiprocessing
import os
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.online._config import Config
from stereorecal.online._events import Event
from stereorecal.online._saving import load, save
from stereorecal.online._state import State
from stereorecal.online._step import init, step
from stereorecal.recordings import Images, Pair

_PATIENCE = 10.0  # seconds that the process has to end by itself
_DEAD = "the process beside has died (exit code {}), and nobody watches the rig; "
_AT_ONCE = 'it imports the program that starts it, which must do so under `if __name__ == "__main__":`.'
_LATER = "look at what it printed, and start another."


class Beside:
    """A rig that is watched and repaired by another process. The newest pair waits, at most one: those that come while
    it is busy take each other's place, and `dropped` counts them.

    Use as a context manager, or call `close`.
    """

    def __init__(
        self,
        rig: StereoRig | State,
        config: Config = Config(),  # noqa: B008
        *,
        keep: str | Path | None = None,
        nice: int = 10,
        seconds: float | None = math.inf,
    ) -> None:
        """Start the process; it is ready some seconds later, and pairs wait until then.

        Args:
            rig: the calibration to start from, or a state to go on from.
            keep: a file in which each state is saved, and from which it goes on, if the file exists; it must be of
                this calibration.
            nice: by how much the process gives way to others.
            seconds: of each step, for a repair, as `step` has it; default all that it takes: pairs that come meanwhile
                are dropped.

        Raises:
            InputError: as `init` and `load`.
        """
        state = rig if isinstance(rig, State) else init(rig, config)
        if keep is not None and Path(keep).exists():
            state = load(keep, None if isinstance(rig, State) else rig)
        # Not forked: JAX has threads, and a copy of a process without them hangs.
        ours, theirs = multiprocessing.get_context("spawn").Pipe()
        context = multiprocessing.get_context("spawn")
        self._process = context.Process(target=_worker, args=(theirs, state, keep, nice, seconds), daemon=True)
        self._lock, self._there = threading.Lock(), threading.Condition()
        self._state, self._events, self._dropped = state, (), 0
        self._waiting: Pair | Images | None = None
        self._closed = self._answered = False
        self._process.start()
        theirs.close()
        self._thread = threading.Thread(target=self._serve, args=(ours,), daemon=True)
        self._thread.start()

    def put(self, pair: Pair | Images) -> bool:
        """Hand over a pair, at once; False if one that waited is dropped for it. The arrays must not change after.

        Raises:
            RuntimeError: if the process has died.
        """
        self._check_alive()
        with self._there:
            dropped = self._waiting is not None
            self._waiting = pair
            self._dropped += dropped
            self._there.notify()
        return not dropped

    def latest(self) -> tuple[State, tuple[Event, ...]]:
        """The newest state, at once, and what has happened since this was asked before.

        Raises:
            RuntimeError: if the process has died, and all that happened before has been told.
        """
        with self._lock:
            events, self._events = self._events, ()
            if not events:
                self._check_alive()
            return self._state, events

    @property
    def dropped(self) -> int:
        """Pairs that nobody looked at."""
        return self._dropped

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.is_alive()

    def close(self) -> None:
        """End the process; the step that it is in is finished, unless that takes too long."""
        with self._there:
            self._closed = True
            self._there.notify()
        self._thread.join(_PATIENCE)
        self._process.join(_PATIENCE)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()

    def _check_alive(self) -> None:
        if not self._closed and not self.alive:
            raise RuntimeError(_DEAD.format(self._process.exitcode) + (_LATER if self._answered else _AT_ONCE))

    def __enter__(self) -> "Beside":
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None):
        self.close()

    def _serve(self, pipe: Connection) -> None:
        """Give pairs to the process, one at a time, and take its answers. Ends with it."""
        with suppress(EOFError, OSError):
            while True:
                with self._there:
                    while self._waiting is None and not self._closed:
                        self._there.wait()
                    pair, self._waiting = self._waiting, None
                    if self._closed:
                        break
                pipe.send(_plain(pair))
                state, events = pipe.recv()
                self._answered = True
                with self._lock:
                    self._state, self._events = state, (*self._events, *events)
        pipe.close()


def _plain(pair: Pair | Images | None) -> Images:
    """The images alone: a pair that came from a file would be read again."""
    assert pair is not None
    return (pair.left, pair.right) if isinstance(pair, Pair) else (np.asarray(pair[0]), np.asarray(pair[1]))


def _worker(pipe: Connection, state: State, keep: str | Path | None, nice: int, seconds: float | None) -> None:
    with suppress(OSError, AttributeError):
        os.nice(nice)
    with suppress(EOFError, KeyboardInterrupt):
        while True:
            state, events = step(state, pipe.recv(), seconds)
            if keep is not None:
                save(state, keep)
            pipe.send((state, events))
