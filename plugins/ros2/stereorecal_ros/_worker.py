"""The life of the worker process: begun and ended without waiting, and begun again when it has exited."""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from typing import Protocol, runtime_checkable

import numpy as np

from stereorecal import InputError, StereoRig
from stereorecal.online import Config, Event, State, reading
from stereorecal_ros._applied import Applied
from stereorecal_ros._kept import Kept, set_aside
from stereorecal_ros._log import Level, Line, Tell
from stereorecal_ros._settings import Settings

_RETRY, _LONGEST_RETRY = 5.0, 60.0  # seconds until a process that exited is replaced; doubled each time

Change = Callable[[State], tuple[State, tuple[Event, ...]]]


@runtime_checkable
class Process(Protocol):
    """What is used of `stereorecal.online.MonitorProcess`, which says what each does."""

    @property
    def ready(self) -> bool: ...

    def put(self, pair: tuple[np.ndarray, np.ndarray, float], /) -> bool: ...

    def change(self, change: Change, /) -> None: ...

    def latest(self) -> tuple[State, tuple[Event, ...]]: ...

    def close(self) -> None: ...


@dataclass(frozen=True, eq=False)
class Begun:
    """A process that has been started, or why it has not.

    Attributes:
        beside: the process; None if there is none.
        state: that it goes on from; without a process one of what is applied, or None.
        applied: what had been applied; None if nothing has been.
        said: lines for the log.
        failed: why there is no process.
    """

    beside: Process | None
    state: State | None
    applied: Applied | None
    said: list[Line]
    failed: str | None = None


class Worker:
    """At most one process at a time, which keeps its state in a file and goes on from it.

    Args:
        kept: the places of what is kept.
        tell: what is called with lines for the log.
        work: makes a `MonitorProcess`.
        clock: seconds.
        background: where processes are begun and ended, one after the other: either takes up to some seconds.
    """

    def __init__(
        self,
        settings: Settings,
        kept: Kept,
        tell: Tell,
        work: Callable[..., Process],
        clock: Callable[[], float],
        background: Executor,
    ) -> None:
        self._settings, self._kept, self._tell, self._work, self._clock = settings, kept, tell, work, clock
        self._background = background
        self._beside: Process | None = None
        self._beginning: Future[Begun] | None = None
        self._retry, self._due = _RETRY, clock()
        self.dead: str | None = None  # why there is none, if it exited

    @property
    def runs(self) -> bool:
        """Whether there is a process."""
        return self._beside is not None

    @property
    def ready(self) -> bool:
        """Whether a pair that is put now is looked at next."""
        return self._beside is not None and self._beside.ready

    def start(self, rig: StereoRig, applied: Applied | None) -> Begun | None:
        """Have one begun, if that is due and none is on its way; returns what came of it once that is known.

        It goes on from the state in the file, if that is of this rig; a file of another rig is set aside.

        Args:
            applied: what has been applied; None if only the file says it.
        """
        if self._beginning is None:
            if self._clock() < self._due:
                return None
            self._beginning = self._background.submit(self._begin, rig, applied)
        if not self._beginning.done():
            return None
        beginning, self._beginning = self._beginning, None
        begun = beginning.result()
        for line in begun.said:
            self._tell(*line)
        self._beside, self.dead = begun.beside, None
        if begun.failed is not None:
            self.end(begun.failed)
        return begun

    def latest(self) -> tuple[State, tuple[Event, ...]] | None:
        """What `MonitorProcess.latest` says; None if there is no process, or it has exited."""
        if self._beside is None:
            return None
        try:
            state, events = self._beside.latest()
        except RuntimeError as error:
            self.end(str(error))
            return None
        if events:
            self._retry = _RETRY
        return state, events

    def put(self, images: tuple[np.ndarray, np.ndarray], seconds: float) -> bool:
        """Hand over a pair, with its time; False if there is no process any more."""
        return self._try(lambda beside: beside.put((*images, seconds)))

    def change(self, change: Change) -> bool:
        """Have the state changed; False if there is no process any more."""
        return self._try(lambda beside: beside.change(change))

    def end(self, why: str | None) -> None:
        """End the process, without waiting; with a reason, because it exited or does not start: the next one comes
        later."""
        if why is not None:
            self.dead = why
            self._tell(Level.ERROR, f"{why} Another try in {self._retry:.0f} s.")
            self._due = self._clock() + self._retry
            self._retry = min(2.0 * self._retry, _LONGEST_RETRY)
        if self._beginning is not None:
            self._background.submit(_close_begun, self._beginning)
            self._beginning = None
        if self._beside is not None:
            self._background.submit(self._beside.close)
            self._beside = None

    def close(self) -> tuple[Event, ...]:
        """End it, and wait until the last state is saved; returns what happened until then."""
        beside = self._beside
        self.end(None)
        self._background.shutdown()
        return () if beside is None else beside.latest()[1]

    def _begin(self, rig: StereoRig, applied: Applied | None) -> Begun:
        said: list[Line] = []
        try:
            if applied is None:
                applied, said = self._kept.read(rig)
            beside = self._made(rig if applied is None else applied.initial, said)
            state, _ = beside.latest()
            reading(state)  # imports what it needs, which takes a third of a second
            return Begun(beside, state, applied, said)
        except (InputError, OSError, RuntimeError) as error:
            return Begun(None, None if applied is None else applied.published, applied, said, str(error))

    def _made(self, rig: StereoRig, said: list[Line]) -> Process:
        settings, place = self._settings, self._kept.state
        config = Config(matcher=settings.matcher, synchronous=settings.synchronous, repair=settings.repair)
        begin = partial(self._work, rig, config, share=settings.share, keep=place, keep_every=settings.keep_every)
        try:
            return begin()
        except InputError as error:
            if not place.exists():
                raise
            said.append(set_aside(place, str(error)))
            return begin()

    def _try(self, act: Callable[[Process], object]) -> bool:
        if self._beside is None:
            return False
        try:
            act(self._beside)
        except RuntimeError as error:
            self.end(str(error))
            return False
        return True


def _close_begun(beginning: "Future[Begun]") -> None:
    beside = beginning.result().beside
    if beside is not None:
        beside.close()
