"""A robot for tests: a watch without ROS, around a worker that is a stand-in."""

import pickle
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from stereorecal_ros import LEFT, RIGHT, CameraInfo, Kept, Level, Settings, Watch, corrected

from stereorecal import StereoRig
from stereorecal.online import Config, Event, Kind, State, init, load, save
from stereorecal.synthetic import default_rig

SIZE = (64, 48)
BETTER, BEST = 0.1 * np.eye(5)[0], 0.2 * np.eye(5)[0]


class AtOnce(Executor):
    """An executor that waits for what it is given."""

    def submit(self, act, /, *given, **named) -> Future:
        done = Future()
        try:
            done.set_result(act(*given, **named))
        except Exception as error:
            done.set_exception(error)
        return done


@cache
def begun(rig_and_config: bytes) -> State:
    """The first state, made and read once for all robots that are alike: most of what a test took."""
    return init(*pickle.loads(rig_and_config))


@dataclass
class Work:
    """A stand-in for `MonitorProcess`: pairs and changes are kept, what it says is set by the test."""

    rig: StereoRig
    config: Config
    keep: Path
    keep_every: float = 0.0
    share: float = 1.0
    ready: bool = True
    exited: bool = False
    closed: bool = False
    events: list[Event] = field(default_factory=list)
    pairs: list[tuple[np.ndarray, np.ndarray, float]] = field(default_factory=list)
    changes: list[partial] = field(default_factory=list)
    waiting: list[partial] = field(default_factory=list)
    slow: bool = False

    def __post_init__(self) -> None:
        self.state = load(self.keep, self.rig) if self.keep.exists() else begun(pickle.dumps((self.rig, self.config)))

    def put(self, images: tuple[np.ndarray, np.ndarray, float]) -> bool:
        self._check()
        self.pairs.append(images)
        return True

    def change(self, change: partial) -> None:
        self._check()
        self.changes.append(change)
        if change.func.__name__ != "recalibrate":
            self.waiting.append(change)

    def latest(self) -> tuple[State, tuple[Event, ...]]:
        self._check()
        while self.waiting and not self.slow:
            self.state, events = self.waiting.pop(0)(self.state)
            self.events += events
        events, self.events = self.events, []
        return self.state, tuple(events)

    def close(self) -> None:
        self.closed = True
        save(self.state, self.keep)

    def accept(self, offset: np.ndarray) -> None:
        """As `stereorecal.online` does when it switches."""
        state = self.state.replace(using=offset)
        self.state = state.replace(previous=(*self.state.previous, self.state.using), frame=self.state.frame + 1)
        self.events.append(Event(self.state.frame, Kind.REPAIRED))

    def _check(self) -> None:
        if self.exited:
            raise RuntimeError("the worker process exited.")


class Robot:
    """A watch, its clock, its log and its workers."""

    def __init__(
        self, folder: Path, rig: StereoRig | None = None, background: Executor | None = None, **settings: Any
    ) -> None:
        self.rig = default_rig().resized(SIZE) if rig is None else rig
        self.now, self.stamp = 100.0, 0
        self.log: list[tuple[Level, str]] = []
        self.works: list[Work] = []
        self.infos: list[CameraInfo | None] = [None, None]  # that come with each image
        tell = lambda level, text: self.log.append((level, text))  # noqa: E731
        self.watch = Watch(
            Settings(**settings),
            Kept(Path(settings.get("state_file", folder / "node.state")), named="state_file" in settings),
            tell,
            work=self._made,
            clock=lambda: self.now,
            background=background or AtOnce(),
        )

    def _made(self, *given: Any, **options: Any) -> Any:
        self.works.append(Work(*given, **options))
        return self.works[-1]

    @property
    def work(self) -> Work:
        return self.works[-1]

    def calibrate(self, rig: StereoRig | None = None) -> None:
        self.infos = list(corrected(self.rig if rig is None else rig))
        self._inform()

    def _inform(self) -> None:
        for side, info in enumerate(self.infos):
            if info is not None:
                self.watch.camera_info(side, message_of(info))

    def see(self, number: int = 1, apart: int = 0, **changes: Any) -> None:
        """Pairs, a tenth of a second each."""
        for _ in range(number):
            self.now += 0.1
            self.stamp += 100_000_000
            self._inform()
            for side, late in ((LEFT, 0), (RIGHT, apart)):
                self.watch.image(side, self.stamp + late, image(**changes))
        self.watch.poll()

    def accept(self, offset: np.ndarray) -> None:
        """The decision accepts a calibration; the next pair comes."""
        self.work.accept(offset)
        self.see()

    def turned(self) -> np.ndarray:
        """Degrees of pitch by which what is published differs from what was given."""
        assert self.watch.rig is not None
        return np.degrees(self.watch.rig.extrinsics - self.rig.extrinsics)[0]

    def said(self, *words: str) -> bool:
        return any(all(word in text for word in words) for _, text in self.log)


def message_of(info: CameraInfo, **changes: Any) -> SimpleNamespace:
    roi = SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0)
    return SimpleNamespace(**{**vars(info), "binning_x": 0, "binning_y": 0, "roi": roi, **changes})


def image(size: tuple[int, int] = SIZE, encoding: str = "mono8", channels: int = 1, depth: int = 1, **changes: Any):
    width, height = size
    data = np.random.default_rng(0).integers(0, 255, width * height * channels * depth, np.uint8)
    content = {"width": width, "height": height, "encoding": encoding, "step": width * channels * depth}
    return SimpleNamespace(**{**content, "is_bigendian": 0, "data": data, **changes})
