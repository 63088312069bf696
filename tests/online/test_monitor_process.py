"""The spare process: nobody waits for it, and it says what it dropped."""

import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from pickle import PicklingError

import numpy as np
import pytest
from rides import Ride, standing_at

import stereorecal as sr
from stereorecal import InputError
from stereorecal.online import Config, Event, Kind, MonitorProcess, State, freeze, init, load, save
from stereorecal.recordings import Pair
from stereorecal.scoring.host import Corners


@pytest.fixture(scope="module")
def running(ride: Ride):
    """One that tests which leave it alive share: a start takes a second."""
    with MonitorProcess(ride.rig) as beside:
        yield beside


def wait_until(done: Callable[[], object]) -> None:
    """Or for two minutes: what comes next fails then."""
    until = time.perf_counter() + 120
    while not done() and time.perf_counter() < until:
        time.sleep(0.02)


def test_a_process_that_died_is_told(ride: Ride):
    black = np.zeros((240, 320), np.uint8)
    with MonitorProcess(ride.rig) as beside:
        assert beside.latest()[1] == ()
        beside._process.kill()
        beside._process.join()
        for use in (beside.latest, lambda: beside.put((black, black))):
            with pytest.raises(RuntimeError, match=r"worker process exited .*__main__"):
                use()
        happened = Event(3, Kind.BAD_FRAME)
        beside._events, beside._answered = (happened,), True
        assert beside.latest()[1] == (happened,)  # what came before is told first
        with pytest.raises(RuntimeError, match="look at what it printed"):
            beside.latest()
    assert beside.latest()[1] == ()


def test_put_never_waits(ride: Ride):
    """Black pairs, which need no compiled program."""
    black = np.zeros((240, 320), np.uint8)
    with MonitorProcess(ride.rig) as beside:
        began = time.perf_counter()
        kept = [beside.put((black, black)) for _ in range(300)]
        assert time.perf_counter() - began < 1.0
        assert kept[0]
        assert not all(kept)
        assert beside.dropped >= kept.count(False) > 0
        assert told(beside, Kind.BAD_FRAME)[0].kind is Kind.BAD_FRAME
        assert beside.latest()[0].using.shape == (5,)
        assert beside.alive
        process, dropped = beside._process, beside.dropped
    assert not process.is_alive()
    assert not beside.put((black, black))
    assert beside.dropped == dropped + 1
    assert process.pid != os.getpid()


def seen(state: State, folder: Path) -> tuple[State, tuple[Event, ...]]:
    """A change; the folder shows that it was made in the process."""
    (folder / "seen").write_text(str(os.getpid()))
    return freeze(state), (Event(state.frame, Kind.HEALTHY, "changed"),)


def refused(state: State) -> tuple[State, tuple[Event, ...]]:
    raise InputError("not this way.")


def told(beside: MonitorProcess, *kinds: Kind) -> list[Event]:
    """What happens until all of these have."""
    events: list[Event] = []

    def all_have() -> bool:
        events.extend(beside.latest()[1])
        return {*kinds} <= {event.kind for event in events}

    wait_until(all_have)
    return events


def counted(state: State) -> tuple[State, tuple[Event, ...]]:
    return state.replace(frame=state.frame + 1), ()


def test_changes_pairs_and_savings(ride: Ride, tmp_path: Path):
    """A change is made in the process, between pairs; a state is saved when something happens, and at the end."""
    noise, kept = np.random.default_rng(0).integers(0, 255, (2, 240, 320), np.uint8), tmp_path / "state"
    state = init(ride.rig, Config(every=1000)).replace(frame=1)  # so that no pair is looked at
    with MonitorProcess(state, keep=kept, keep_every=math.inf) as beside:
        assert beside.ready
        beside.change(partial(seen, folder=tmp_path))
        assert not beside.ready
        beside.change(refused)
        events = told(beside, Kind.REFUSED)
        assert [event.kind for event in events] == [Kind.HEALTHY, Kind.REFUSED]
        assert events[1].why == "not this way."
        wait_until(lambda: beside.ready)
        assert int((tmp_path / "seen").read_text()) != os.getpid()
        assert not beside.latest()[0].config.repair
        assert not load(kept).config.repair
        beside.put((noise[0], noise[1]))
        wait_until(lambda: beside.latest()[0].frame != 1)
        assert load(kept).frame == 1
        for _ in range(3):
            beside.change(counted)  # made before the end, where a pair that waits is dropped
        beside.put((noise[0], noise[1]))
    assert load(kept).frame == beside.latest()[0].frame == 5


def with_corners(state: State) -> tuple[State, tuple[Event, ...]]:
    none = np.zeros((0, 2))
    return state.replace(corners=Corners(np.zeros((240, 320), np.uint8), none, none)), ()


def told_corners(state: State) -> tuple[State, tuple[Event, ...]]:
    return state, (Event(state.frame, Kind.HEALTHY, "lost" if state.corners is None else "kept"),)


def test_the_images_of_corners_stay_in_the_process(running: MonitorProcess):
    running.latest()  # what happened before
    running.change(with_corners)
    running.change(told_corners)
    (event,) = told(running, Kind.HEALTHY)
    assert event.why == "kept"
    assert running.latest()[0].corners is None


def followed(state: State, since: int) -> tuple[State, tuple[Event, ...]]:
    """Corners that were found so many pairs ago, at 4 seconds; a step that cannot find them again looks sooner."""
    none = np.zeros((0, 2))
    corners = Corners(np.zeros((240, 320), np.uint8), none, none)
    return state.replace(corners=corners, corners_frame=state.frame - since, corners_time=4.0, tracked_pairs=4), ()


def test_the_times_of_pairs_reach_the_steps(running: MonitorProcess):
    """What is followed is given up where the clock jumps back."""
    left, right = np.random.default_rng(0).integers(0, 4, (2, 240, 320), np.uint8) * 64  # too coarse for a look
    pairs = [
        ((left, right, 5.0), 50, True),
        (Pair(left.astype(np.float32), right.astype(np.float32), time=5.5), 50, True),
        ((left, right, 5.2), 50, False),
        ((left, right), 50, False),
        ((left, right), 5, True),
        ((left, right, 7.0), 50, False),
    ]
    for number, (pair, since, looked_for) in enumerate(pairs, running.latest()[0].frame + 1):
        running.change(partial(followed, since=since))
        running.put(pair)
        wait_until(lambda number=number: running.latest()[0].frame >= number)
        state, _ = running.latest()
        assert (state.frame, state.tracked_pairs) == (number, 2 if looked_for else 4)
        assert state.last is None  # images stay there


@pytest.mark.slow
def test_the_settings_that_are_given_count_where_a_state_is_kept(ride: Ride, tmp_path: Path):
    place = tmp_path / "state"
    known = sr.SAD(num_disparities=48)
    narrow = init(ride.rig)
    narrow = narrow.replace(frame=7, matcher=known, estimate=standing_at(narrow, np.ones(5), 1e-6 * np.eye(5)))

    def settled(state: State, config: Config) -> State:
        save(state, place)
        with MonitorProcess(ride.rig, config, keep=place) as beside:
            return beside.latest()[0]

    same = settled(narrow, Config())
    assert same.matcher == known
    np.testing.assert_array_equal(same.estimate.covariance, narrow.estimate.covariance)
    with MonitorProcess(ride.rig, Config(matcher=sr.SAD(block_size=9), every=3, prior="exact"), keep=place) as beside:
        other = beside.latest()[0]
    assert other.config.every == 3
    assert other.frame == 7
    assert other.matcher is None
    assert not np.any(other.estimate.of_theta[5:])  # of lenses
    assert other.of_offset[0, 0] > 0.01
    np.testing.assert_allclose(other.offset, np.ones(5), atol=1e-9)
    assert not settled(freeze(narrow), Config(every=2)).config.repair


@pytest.mark.usefixtures("unchecked")
def test_what_cannot_be_sent_is_refused_where_it_is_given(running: MonitorProcess):
    image = np.zeros((240, 320), np.uint8)
    with pytest.raises((AttributeError, TypeError, PicklingError)):
        running.change(lambda state: (state, ()))
    for pair in ((image,), (image, np.array([None])), (image, image, "now"), 3):
        with pytest.raises(InputError, match="the pair"):
            running.put(pair)
    running.change(told_corners)
    assert told(running, Kind.HEALTHY)
    assert running.alive


class Unreadable(str):
    """That only one process can make."""

    def __reduce__(self):
        return unreadable, (os.getpid(),)


def unreadable(process: int) -> str:
    if os.getpid() != process:
        raise ValueError("not here.")
    return ""


def unreadable_here(state: State) -> tuple[State, tuple[Event, ...]]:
    return state, (Event(state.frame, Kind.HEALTHY, Unreadable()),)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_died_is_told(ride: Ride):
    with MonitorProcess(ride.rig) as beside:
        beside.change(unreadable_here)
        beside._thread.join(120)
        assert not beside.alive
        with pytest.raises(RuntimeError, match="worker process exited"):
            beside.change(told_corners)
        with pytest.raises(RuntimeError, match="worker process exited"):
            beside.latest()


@pytest.mark.slow
def test_a_share_of_a_core(ride: Ride):
    """A process that has had its share rests, and is not ready; closing does not wait for it."""
    black = np.zeros((240, 320), np.uint8)
    with pytest.raises(InputError, match="above 0"):
        MonitorProcess(ride.rig, share=0.0)
    with MonitorProcess(ride.rig, share=1e-6) as beside:
        beside.put((black, black))
        wait_until(lambda: beside.latest()[1])
        assert not beside.ready
        assert beside.put((black, black))
        assert not beside.put((black, black))
    assert beside.latest()[0].frame == 1


def test_a_place_that_cannot_be_written_to_is_told_once_and_the_rig_is_watched_on(ride: Ride, tmp_path: Path):
    """A folder that is not there yet stands for a disk that is full."""
    place = tmp_path / "later" / "state"
    happens = partial(seen, folder=tmp_path)
    with MonitorProcess(init(ride.rig, Config(every=1000)), keep=place, keep_every=math.inf) as beside:
        beside.change(happens)
        beside.change(happens)
        beside.change(refused)
        events = told(beside, Kind.REFUSED)
        assert [event.kind for event in events].count(Kind.NOT_SAVED) == 1
        assert "later" in next(event.why for event in events if event.kind is Kind.NOT_SAVED)
        place.parent.mkdir()
        beside.change(happens)
        assert told(beside, Kind.SAVED)
        assert load(place).frame == 0
        place.unlink()
        place.parent.rmdir()
        beside.change(happens)
    assert Kind.NOT_SAVED in [event.kind for event in beside.latest()[1]]  # at the end, too


def test_the_last_state_is_saved_when_the_program_is_killed(tmp_path: Path):
    """In the middle of a step, whose answer nobody takes any more."""
    place = tmp_path / "state"
    program = tmp_path / "program.py"
    program.write_text(
        "import sys, time\n"
        "from pathlib import Path\n"
        "from stereorecal.online import MonitorProcess\n"
        "from stereorecal.synthetic import default_rig\n"
        "def slow(state):\n"
        f"    Path({str(tmp_path / 'begun')!r}).touch()\n"
        "    time.sleep(1.0)\n"
        "    return state.replace(frame=7), ()\n"
        "if __name__ == '__main__':\n"
        f"    beside = MonitorProcess(default_rig(), keep={str(place)!r}, keep_every=1e9)\n"
        "    beside.change(slow)\n"
        "    time.sleep(100)\n"
    )
    with subprocess.Popen([sys.executable, program], stderr=subprocess.PIPE) as running:
        wait_until((tmp_path / "begun").exists)
        running.kill()
        _, said = running.communicate()  # which the worker holds open until it ends
    assert said == b""
    assert load(place).frame == 7
