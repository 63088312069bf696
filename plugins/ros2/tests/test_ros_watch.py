"""The node without ROS, around a worker that is a stand-in: what is published, and what never is."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from stereorecal_ros import Level, Settings, Watch, corrected
from stereorecal_ros._camera_info import CameraInfo
from stereorecal_ros._pairing import LEFT, RIGHT
from stereorecal_ros._worker import _RETRY

from stereorecal import InputError, StereoRig
from stereorecal.io import load_rig, save_rig
from stereorecal.online import Config, Event, Kind, State, init, load, save
from stereorecal.synthetic import default_rig

SIZE = (64, 48)
BETTER, BEST = 0.1 * np.eye(5)[0], 0.2 * np.eye(5)[0]


@dataclass
class Work:
    """A stand-in for `Beside`: pairs and changes are kept, what it says is set by the test."""

    rig: StereoRig
    config: Config
    keep: Path
    keep_every: float = 0.0
    share: float = 1.0
    ready: bool = True
    exited: bool = False
    closed: bool = False
    events: list[Event] = field(default_factory=list)
    pairs: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    changes: list[partial] = field(default_factory=list)
    waiting: list[partial] = field(default_factory=list)
    slow: bool = False

    def __post_init__(self) -> None:
        self.state = load(self.keep, self.rig) if self.keep.exists() else init(self.rig, self.config)

    def put(self, images: tuple[np.ndarray, np.ndarray]) -> bool:
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
        """As `stereorecal.online` does when a candidate has won."""
        state = self.state.using_now(offset)
        self.state = state.but(previous=(*self.state.previous, self.state.using), frame=self.state.frame + 1)
        self.events.append(Event(self.state.frame, Kind.REPAIRED))

    def _check(self) -> None:
        if self.exited:
            raise RuntimeError("the process beside has died.")


class Robot:
    """A watch, its clock, its log and its workers."""

    def __init__(self, folder: Path, rig: StereoRig | None = None, **settings: Any) -> None:
        self.rig = default_rig().resized(SIZE) if rig is None else rig
        self.now, self.stamp = 100.0, 0
        self.log: list[tuple[Level, str]] = []
        self.works: list[Work] = []
        self.infos: list[CameraInfo | None] = [None, None]  # that come with each image
        place = folder / "node.state"
        tell = lambda level, text: self.log.append((level, text))  # noqa: E731
        self.watch = Watch(Settings(**settings), place, tell, work=self._made, clock=lambda: self.now)

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


@pytest.fixture
def robot(tmp_path: Path) -> Callable[..., Robot]:
    return partial(Robot, tmp_path)


def test_a_calibration_waits_until_it_is_applied_and_can_be_taken_back(robot):
    one = robot()
    assert one.watch.corrected is None
    assert not one.watch.apply()[0]
    one.calibrate()
    one.see()
    given = one.watch.corrected
    assert [a.is_like(b) for a, b in zip(given, corrected(one.rig), strict=True)] == [True, True]
    one.accept(BETTER)
    assert one.watch.corrected == given
    status = one.watch.status()
    assert "waits for ~/apply" in status.message
    done, said = one.watch.apply()
    assert done
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    assert one.watch.corrected != given
    assert "->" in said
    assert one.said("applied", said)
    assert not one.watch.apply()[0]
    done, _ = one.watch.roll_back()
    assert done
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert not one.watch.settings.repair
    assert not one.work.state.config.repair
    np.testing.assert_array_equal(one.work.state.using, np.zeros(5))
    assert "waits" not in one.watch.status().message
    assert not one.watch.roll_back()[0]


def test_auto_apply_applies_what_is_accepted_and_nothing_after_a_roll_back(robot):
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    one.watch.roll_back()
    one.see()
    one.accept(BEST)  # as a recalibration on request would
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    one.watch.set(repair=True)
    one.see()
    assert one.turned() == pytest.approx(0.2, abs=0.01)
    assert one.said("repair: False -> True")


def test_what_is_taken_back_does_not_come_back_while_the_worker_is_busy(robot):
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.work.slow = True
    one.watch.roll_back()
    one.see()
    one.watch.set(repair=True)
    one.see()
    assert not one.watch.apply()[0]
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert "waits" not in one.watch.status().message
    one.work.slow = False
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)


def test_auto_apply_switched_on_later(robot):
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.set(auto_apply=True)
    assert one.turned() == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize("kind", [kind for kind in Kind if kind is not Kind.REPAIRED], ids=lambda kind: kind.name)
def test_no_event_alone_changes_what_is_published(robot, kind: Kind):
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.work.events.append(Event(3, kind, "why"))
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)


def test_it_goes_on_after_a_restart(robot):
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.apply()
    one.accept(BEST)
    one.watch.close()
    two = robot()
    two.calibrate()
    two.see()
    assert two.turned() == pytest.approx(0.1, abs=0.01)  # what was applied, and not what waits
    assert "waits" in two.watch.status().message
    assert two.watch.roll_back()[0]
    two.watch.close()
    three = robot(auto_apply=True)
    three.calibrate()
    three.see()
    assert three.turned() == pytest.approx(0.0, abs=1e-9)
    assert not three.watch.settings.repair  # what was rolled back stays so


def test_the_driver_gives_what_was_applied(robot):
    """As it does after `set_camera_info`, one camera after the other: nothing begins anew."""
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.apply()
    applied = one.watch.rig
    one.infos[LEFT] = corrected(applied)[LEFT]
    one.see(40)  # a driver that takes its time, or refuses: half of it is no calibration
    assert len(one.works) == 1
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    assert one.said("halves of two calibrations")
    one.infos[RIGHT] = corrected(applied)[RIGHT]
    one.see(30)
    assert len(one.works) == 1
    assert not one.said("another calibration")


def test_another_calibration_begins_anew_once_it_has_settled(robot, tmp_path: Path):
    one = robot()
    one.calibrate()
    one.see()
    other = one.rig.with_extrinsics(one.rig.extrinsics + np.array([0.02, 0, 0, 0, 0, 0]))
    one.calibrate(other)
    one.see(5)
    assert len(one.works) == 1
    one.see(30)
    for _ in range(100):  # the old process ends in a thread
        if len(one.works) > 1:
            break
        one.watch._worker._ending.join()
        one.see()
    assert one.works[0].closed
    assert one.said("another calibration is given", "->")
    assert one.said("another calibration than the one that is given", "node.state.bak")
    np.testing.assert_allclose(one.watch.rig.extrinsics, other.extrinsics, atol=1e-9)
    assert (tmp_path / "node.state.bak").exists()


def test_a_worker_that_exits_is_told_and_replaced(robot):
    one = robot()
    one.calibrate()
    one.see()
    given = one.watch.corrected
    one.work.exited = True
    one.see()
    assert one.watch.status().level is Level.ERROR
    assert "has died" in one.watch.status().message
    assert one.watch.corrected == given
    assert not one.watch.recalibrate()[0]
    one.now += _RETRY
    one.watch._worker._ending.join()
    one.see()
    assert len(one.works) == 2
    assert "has died" not in one.watch.status().message


@pytest.mark.parametrize("what", ["state", "applied"])
def test_a_file_that_is_damaged_is_set_aside(robot, tmp_path: Path, what: str):
    name = {"state": "node.state", "applied": "node.state.applied.json"}[what]
    (tmp_path / name).write_text('{"schema": "stereorecal.ros-applied/1"')
    one = robot()
    one.calibrate()
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert one.said(name, "kept as")
    assert (tmp_path / f"{name}.bak").exists()


@pytest.mark.parametrize("auto_apply", [False, True])
def test_a_state_begun_anew_offers_nothing_that_was_not_accepted(robot, tmp_path: Path, auto_apply: bool):
    """What it begins with is what was given at first, and bad by then."""
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    one.watch.close()
    (tmp_path / "node.state").write_text("cut off")
    two = robot(auto_apply=auto_apply)
    two.calibrate()
    two.see(3)
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    assert "waits" not in two.watch.status().message
    two.watch.apply()
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    two.accept(BEST)
    two.watch.apply()
    assert two.turned() == pytest.approx(0.2, abs=0.01)


def test_a_correction_is_of_one_calibration_with_all_that_it_consists_of(robot):
    """Another one may stand alike, with other lenses."""
    one = robot(auto_apply=True)
    one.calibrate()
    one.see()
    one.accept(BETTER)
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    one.watch.close()
    two = robot()
    lenses = replace(two.rig.left, distortion=np.array([-0.1, 0.02, 0.0, 0.0]))
    two.rig = replace(two.rig, left=lenses)
    two.calibrate()
    two.see()
    assert two.turned() == pytest.approx(0.0, abs=1e-9)


def test_what_was_applied_outlives_a_worker_though_no_file_could_hold_it(robot, monkeypatch: pytest.MonkeyPatch):
    one = robot()
    one.calibrate()
    one.see()
    one.accept(BETTER)
    monkeypatch.setattr("stereorecal_ros._applied.write_json", lambda *_: (_ for _ in ()).throw(InputError("full")))
    one.watch.apply()
    one.work.exited = True
    one.see()
    one.now += _RETRY
    one.watch._worker._ending.join()
    one.see()
    assert len(one.works) == 2
    assert one.turned() == pytest.approx(0.1, abs=0.01)


def test_what_it_cannot_follow_is_dropped_and_counted(robot):
    one = robot()
    one.calibrate()
    one.see()
    one.see(2)
    one.work.ready = False
    one.see(20)
    assert len(one.work.pairs) == 2  # the first pair came before there was a worker
    assert one.watch.status().values["pairs dropped, which could not be followed"] == "21"
    assert one.watch.status().values["pairs"] == "23"


def compressed(ending: str, kind: type = np.uint8) -> SimpleNamespace:
    """As `CompressedImage`, which has no encoding."""
    pixels = np.random.default_rng(0).integers(0, 255, SIZE[::-1]).astype(kind)
    return SimpleNamespace(format=ending[1:], data=cv2.imencode(ending, pixels)[1].tobytes())


ENCODINGS = {
    "mono8": image(),
    "mono16": image(encoding="mono16", depth=2),
    "bgr8": image(encoding="bgr8", channels=3),
    "rgb8": image(encoding="rgb8", channels=3),
    "bgra8": image(encoding="bgra8", channels=4),
    "bayer_rggb8": image(encoding="bayer_rggb8"),
    "bayer_gbrg16": image(encoding="bayer_gbrg16", depth=2),
    "jpeg": compressed(".jpg"),
    "png, mono16": compressed(".png", np.uint16),
}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_encodings_become_grey(robot, encoding: str):
    one = robot()
    one.calibrate()
    one.see()
    for side in (LEFT, RIGHT):
        one.watch.image(side, 10**12, ENCODINGS[encoding])
    ((left, right),) = one.work.pairs
    assert left.shape == right.shape == SIZE[::-1]
    assert left.dtype == (np.uint16 if "16" in encoding else np.uint8)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"encoding": "nv21"}, "encoding nv21 is not known"),
        ({"encoding": "32FC1"}, "encoding 32FC1 is not known"),
        ({"encoding": "rgb8"}, "cut short"),
        ({"width": 0}, "cut short"),
        ({"height": 0}, "cut short"),
        ({"data": np.zeros(5, np.uint8)}, "cut short"),
        ({"size": (32, 24)}, "the image is 32x24, and the calibration of 64x48"),
    ],
)
def test_images_that_cannot_be_used_are_told_once(robot, changes, said):
    one = robot()
    one.calibrate()
    one.see()
    one.see(50, **changes)
    assert one.work.pairs == []
    assert sum(said in text for _, text in one.log) == 1
    status = one.watch.status()
    assert status.values["pairs refused"] == "50"
    assert said in status.message
    assert status.level is Level.STALE
    one.see()
    assert said not in one.watch.status().message


def test_a_topic_that_is_silent_is_named(robot):
    one = robot()
    assert one.watch.status().level is Level.STALE
    assert "left/image_raw, right/image_raw, left/camera_info, right/camera_info" in one.watch.status().message
    one.calibrate()
    for number in range(100):
        one.now += 0.1
        one.watch.image(LEFT, number * 100_000_000, image())
    assert "missing: right/image_raw, left/camera_info, right/camera_info" in one.watch.status().message
    one.see(30, apart=20_000_000)
    assert "stamps are" in one.watch.status().message
    assert "tolerance is 5.0 ms" in one.watch.status().message
    one.see()
    assert one.watch.status().values["missing"] == "nothing"


def test_time_that_jumps_back_is_told(robot):
    one = robot()
    one.calibrate()
    one.see(20)
    one.stamp = 0
    one.see(20)
    assert one.said("time has jumped back")
    assert one.watch.status().values["jumps back in time"] == "1"
    assert one.watch.status().values["pairs"] == "40"


def test_camera_info_that_is_none(robot):
    one = robot()
    left, right = corrected(one.rig)
    one.watch.camera_info(LEFT, message_of(left, binning_x=2))
    assert one.said("left/camera_info", "binned")
    one.watch.camera_info(LEFT, message_of(left))
    one.watch.camera_info(RIGHT, message_of(right, k=(0.0,) * 9))
    one.see(30)
    assert one.works == []
    assert one.watch.corrected is None
    assert one.said("right/camera_info", "not calibrated")
    one.calibrate()
    one.see(30)
    assert len(one.works) == 1


def test_a_recalibration_rests_on_other_views_of_one_rig(robot):
    one = robot()
    assert not one.watch.recalibrate()[0]
    one.calibrate()
    one.watch.poll()
    assert one.watch.recalibrate() == (False, "no pair has come yet.")
    one.see(45)
    done, said = one.watch.recalibrate()
    assert done
    assert "last 4 pairs" in said
    assert len(one.work.changes[-1].keywords["pairs"]) == 4
    assert one.watch.recalibrate() == (False, "a recalibration is under way.")
    one.work.events.append(Event(45, Kind.REJECTED, "no candidate"))
    one.work.events.append(Event(46, Kind.KNOCK))
    one.watch.poll()
    assert one.watch.recalibrate() == (False, "no pair has come yet.")  # that shows the knocked rig
    one.see()
    assert one.watch.recalibrate()[0]


def test_files_are_read_and_saved_with_a_copy(robot, tmp_path: Path):
    files = (str(tmp_path / "left.yaml"), str(tmp_path / "right.yaml"))
    rig = default_rig().resized(SIZE)
    save_rig(rig, files, format="ros")
    before = [Path(name).read_bytes() for name in files]
    one = robot(calibration=files)
    assert one.watch.corrected is not None
    one.see()
    assert one.watch.status().values["missing"] == "nothing"
    one.accept(BETTER)
    one.watch.apply()
    done, said = one.watch.save()
    assert done
    assert f"{files[0]}.bak" in said
    assert [Path(f"{name}.bak").read_bytes() for name in files] == before
    np.testing.assert_allclose(load_rig(files).extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    one.watch.close()
    two = robot(calibration=files)  # which now hold what was applied
    two.see()
    np.testing.assert_allclose(two.watch.rig.extrinsics, one.watch.rig.extrinsics, atol=1e-9)
    assert not two.said("new one begun")
    three = Robot(tmp_path / "other")
    assert not three.watch.save()[0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"transport": "theora"},
        {"tolerance": -1.0},
        {"tolerance": float("nan")},
        {"keep_every": float("inf")},
        {"silent_after": 0.0},
        {"share": 0.0},
        {"share": 1.5},
        {"matcher": "magic"},
        {"calibration": ("a", "b", "c")},
    ],
    ids=str,
)
def test_settings_that_make_no_sense(wrong):
    with pytest.raises(InputError):
        Settings(**wrong)
