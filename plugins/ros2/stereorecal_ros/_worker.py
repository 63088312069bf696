"""The life of the worker process: begun, ended without waiting, and begun again when it has exited."""

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from stereorecal import InputError, StereoRig
from stereorecal.io import back_up
from stereorecal.online import Beside, Config, Event, State
from stereorecal_ros._settings import Settings
from stereorecal_ros._status import Level

_RETRY, _LONGEST_RETRY = 5.0, 60.0  # seconds until a process that exited is replaced; doubled each time

Tell = Callable[[Level, str], None]
Change = Callable[[State], tuple[State, tuple[Event, ...]]]


class Worker:
    """At most one process at a time, which keeps its state in a file and goes on from it.

    Args:
        place: that file.
        tell: what is called with lines for the log.
        work: makes a `Beside`.
        clock: seconds.
    """

    def __init__(
        self, settings: Settings, place: Path, tell: Tell, work: Callable[..., Beside], clock: Callable[[], float]
    ) -> None:
        self._settings, self._place, self._tell, self._work, self._clock = settings, place, tell, work, clock
        self._beside: Beside | None = None
        self._ending: threading.Thread | None = None
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

    def start(self, rig: StereoRig) -> State | None:
        """Begin, if that is due: from the state in the file, if it is of this rig; returns the state. A file of another
        rig is set aside."""
        if self._clock() < self._due or (self._ending is not None and self._ending.is_alive()):
            return None
        settings = self._settings
        config = Config(matcher=settings.matcher, repair=settings.repair)
        kept = {"keep": self._place, "keep_every": settings.keep_every}
        begin = partial(self._work, rig, config, share=settings.share, **kept)
        try:
            try:
                self._beside = begin()
            except InputError as error:
                if not self._place.exists():
                    raise
                set_aside(self._place, error, self._tell)
                self._beside = begin()
            state, _ = self._beside.latest()
        except (InputError, OSError, RuntimeError) as error:
            self.end(str(error))
            return None
        self.dead = None
        return state

    def latest(self) -> tuple[State, tuple[Event, ...]] | None:
        """What `Beside.latest` says; None if there is no process, or it has exited."""
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

    def put(self, images: tuple[np.ndarray, np.ndarray]) -> bool:
        """Hand over a pair; False if there is no process any more."""
        return self._try(lambda beside: beside.put(images))

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
        if self._beside is not None:
            self._ending = threading.Thread(target=self._beside.close, daemon=True)
            self._ending.start()
            self._beside = None

    def close(self) -> None:
        """End it, and wait until the last state is saved."""
        self.end(None)
        if self._ending is not None:
            self._ending.join()

    def _try(self, act: Callable[[Beside], object]) -> bool:
        if self._beside is None:
            return False
        try:
            act(self._beside)
        except RuntimeError as error:
            self.end(str(error))
            return False
        return True


def set_aside(path: Path, error: InputError, tell: Tell) -> None:
    """Keep a copy of a file that cannot be used, and remove it."""
    tell(Level.WARN, f"{error} It is kept as {back_up(path)}, and a new one begun.")
    path.unlink()
