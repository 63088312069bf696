"""Steps in a process of its own, beside a capture loop that must not wait."""

import math
import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from types import TracebackType

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.online._config import Config, Event, Kind
from stereorecal.online._saving import StateFile, load
from stereorecal.online._state import State
from stereorecal.online._step import init, step
from stereorecal.recordings import Images, Pair, as_pairs

Change = Callable[[State], tuple[State, tuple[Event, ...]]]
Timed = tuple[np.ndarray, np.ndarray, float | None]  # and seconds
Taken = tuple[np.ndarray, np.ndarray, float | None, float]  # and the readout of rolling shutters
"""The images of a pair, and when it was taken, seconds of any clock; None if that is not known."""

_NICE = 10  # by how much the process gives way to others
_PATIENCE = 10.0  # seconds that the process has to end by itself
_LONGEST_REST = 10.0  # seconds
_DEAD = "the worker process exited (exit code {}), and the rig is not watched; "
_AT_ONCE = 'it imports the program that starts it, which must do so under `if __name__ == "__main__":`.'
_LATER = "look at what it printed, and start another."


class MonitorProcess(AbstractContextManager["MonitorProcess"]):
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
        keep_every: float = 0.0,
        seconds: float | None = math.inf,
        share: float = 1.0,
    ) -> None:
        """Start the process; it is ready some seconds later, and pairs wait until then.

        Args:
            rig: the calibration to start from, or a state to go on from (whose own config counts).
            config: as it is set now, also where a state in a file was set otherwise: with another matcher the range
                is measured anew, with another view or prior the estimate is as wide as at the start. But one that is
                frozen, as after `rollback`, stays so until it is thawed.
            keep: a file in which each state is saved, and from which it goes on, if the file exists; it must be of
                this calibration.
            keep_every: seconds between two savings, at least, unless something has happened; the last state is saved
                at the end. Where that fails it goes on, and says so: NOT_SAVED, and SAVED when it succeeds again.
            seconds: of each step, for a repair, as `step` has it; default all that it takes: pairs that come meanwhile
                are dropped.
            share: of one core, above 0 and at most 1: after each step the process rests until its processor time is
                no more than that; after a long one, such as the first, which compiles, for ten seconds at most.

        Raises:
            InputError: as `init` and `load`, or if the share makes no sense.
        """
        if not 0.0 < share <= 1.0:
            raise InputError(f"a share of {share} of a core makes no sense; give one above 0, and at most 1.")
        state = rig if isinstance(rig, State) else init(rig, config)
        if keep is not None and Path(keep).exists():
            kept, config = load(keep, None if isinstance(rig, State) else rig), state.config
            state = kept.configured(replace(config, repair=config.repair and kept.config.repair))
        # Not forked: JAX has threads, and a copy of a process without them hangs.
        context, begin = multiprocessing.get_context("spawn"), state.alone()
        ours, theirs = context.Pipe()
        arguments = (theirs, begin, StateFile(keep, keep_every, written=begin), seconds, share)
        self._process = context.Process(target=_worker, args=arguments, daemon=True)
        self._there = threading.Condition()
        self._state, self._events, self._dropped = state, (), 0
        self._waiting: Taken | None = None
        self._changes: deque[bytes] = deque()  # pickled
        self._working = False
        self._closed = self._answered = False
        self._process.start()
        theirs.close()
        self._thread = threading.Thread(target=self._serve, args=(ours,), daemon=True)
        self._thread.start()

    def put(self, pair: Pair | Images | Timed) -> bool:
        """Hand over a pair, at once; False if one that waited is dropped for it, or this has been closed. The arrays
        must not change after.

        Args:
            pair: a `Pair`, or (left, right), or (left, right, seconds): where the time is known, of any clock, no
                corner is followed over a gap.

        Raises:
            InputError: if it is none of these.
            RuntimeError: if the worker process has exited.
        """
        self._check_alive()
        sent = _images_alone(pair)
        with self._there:
            dropped = self._closed or self._waiting is not None
            self._waiting = sent
            self._dropped += dropped
            self._there.notify()
        return not dropped

    def latest(self) -> tuple[State, tuple[Event, ...]]:
        """The newest state, at once, and what has happened since this was asked before.

        Raises:
            RuntimeError: if the worker process has exited, and all that happened before has been told.
        """
        with self._there:
            events, self._events = self._events, ()
            if not events:
                self._check_alive()
            return self._state, events

    def change(self, change: Change) -> None:
        """Have the state changed in the process, before the next pair, by a function that can be pickled, such as
        `partial(recalibrate, pairs=pairs)`; `latest` tells the events that it returns. One that raises an InputError
        leaves the state as it is, and is told as REFUSED.

        Raises:
            RuntimeError: if the worker process has exited.
            Exception: whatever pickle raises of a function that cannot be pickled.
        """
        self._check_alive()
        sent = bytes(ForkingPickler.dumps(change))  # here, and not in a thread whose exceptions nobody hears of
        with self._there:
            self._changes.append(sent)
            self._there.notify()

    @property
    def dropped(self) -> int:
        """Pairs that nobody looked at."""
        return self._dropped

    @property
    def ready(self) -> bool:
        """Whether a pair that is put now is looked at as soon as it can be, and takes no other's place: a capture loop
        that asks first need not prepare what would be dropped."""
        return self._waiting is None and not self._working and not self._changes

    @property
    def alive(self) -> bool:
        """Whether the process runs, and is given what comes."""
        return self._process.is_alive() and self._thread.is_alive()

    def close(self) -> None:
        """End the process; the step that it is in is finished and changes that wait are made, unless that takes too
        long. What has happened until then is still told by `latest`."""
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

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None):
        self.close()

    def _serve(self, pipe: Connection) -> None:
        """Give pairs to the process, one at a time, and take its answers. Ends with it, and it with this."""
        with pipe, suppress(EOFError, OSError):
            while True:
                with self._there:
                    self._there.wait_for(lambda: self._waiting is not None or self._changes or self._closed)
                    self._working = True
                    if self._changes:
                        sent = self._changes.popleft()
                    elif self._closed:
                        sent = None
                    else:
                        sent, self._waiting = self._waiting, None
                if isinstance(sent, bytes):
                    pipe.send_bytes(sent)
                else:
                    pipe.send(sent)
                state, events, pause = pipe.recv()
                with self._there:
                    self._state, self._events, self._answered = state, (*self._events, *events), True
                    if sent is None:
                        break
                    self._there.wait_for(lambda: self._closed, pause)
                    self._working = False


def _images_alone(pair: Pair | Images | Timed) -> Taken:
    """Images, time and readout alone: a pair that came from a file would be read again."""
    if isinstance(pair, Pair):
        pair = pair.as_taken()
        return pair.left, pair.right, pair.time, pair.readout
    try:
        left, right, *time = pair
        (seconds,) = time or (None,)
        images, seconds = (np.asarray(left), np.asarray(right)), None if seconds is None else float(seconds)
    except (TypeError, ValueError) as error:
        raise InputError(f"the pair is none ({error}); give (left, right) or (left, right, seconds).") from error
    if any(image.dtype.hasobject for image in images):
        raise InputError("the images of the pair are no arrays of numbers; give (left, right) or a Pair.")
    return *images, seconds, 0.0


def _timed(images: Taken) -> Pair | Images:
    """As a step takes it. What is wrong with images, it says itself."""
    left, right, seconds, readout = images
    with suppress(InputError):
        (pair,) = as_pairs((left, right))
        return replace(pair, time=seconds, readout=readout)
    return left, right


def _worker(pipe: Connection, state: State, file: StateFile, seconds: float | None, share: float) -> None:
    with suppress(OSError, AttributeError):
        os.nice(_NICE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that started it, which ends it in order
    at, ends = None, False
    while not ends:
        try:
            sent = pipe.recv()
        except (EOFError, OSError):  # the program has been killed
            sent = None
        began, spent, events, ends = time.monotonic(), time.process_time(), (), sent is None
        if isinstance(sent, tuple):
            before, at = at, sent[2]
            if before is not None and at is not None and at <= before:  # the clock has jumped
                state = state.alone()
            state, events = step(state, _timed(sent), seconds)
        elif sent is not None:
            state, events = _changed(state, sent)
        events = (*events, *file.keep(state, now=ends or bool(events)))
        rest = (time.process_time() - spent) / share - (time.monotonic() - began)
        with suppress(OSError):  # likewise
            pipe.send((state.alone(), events, min(max(rest, 0.0), _LONGEST_REST)))


def _changed(state: State, change: Change) -> tuple[State, tuple[Event, ...]]:
    try:
        return change(state)
    except InputError as error:
        return state, (Event(state.frame, Kind.REFUSED, str(error)),)
