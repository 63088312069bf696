"""The spare process: nobody waits for it, and it says what it dropped."""

import math
import os
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rides import Ride

from stereorecal import InputError
from stereorecal.online import Beside, Config, Event, Kind, State, freeze, init, load


def test_a_process_that_died_is_told(ride: Ride):
    black = np.zeros((240, 320), np.uint8)
    with Beside(ride.rig) as beside:
        assert beside.latest()[1] == ()
        beside._process.kill()
        beside._process.join()
        for use in (beside.latest, lambda: beside.put((black, black))):
            with pytest.raises(RuntimeError, match=r"has died .*__main__"):
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
    with Beside(ride.rig) as beside:
        began = time.perf_counter()
        kept = [beside.put((black, black)) for _ in range(300)]
        assert time.perf_counter() - began < 1.0
        assert kept[0]
        assert not all(kept)
        assert beside.dropped >= kept.count(False) > 0
        assert beside.latest()[0].using.shape == (5,)
        happened = []
        until = time.perf_counter() + 120
        while not happened and time.perf_counter() < until:
            beside.put((black, black))
            happened = list(beside.latest()[1])
            time.sleep(0.05)
        assert happened[0].kind is Kind.BAD_FRAME
        assert beside.alive
        process = beside._process
    assert not process.is_alive()
    assert process.pid != os.getpid()


def seen(state: State, folder: Path) -> tuple[State, tuple[Event, ...]]:
    """A change; the folder shows that it was made in the process."""
    (folder / "seen").write_text(str(os.getpid()))
    return freeze(state), (Event(state.frame, Kind.HEALTHY, "changed"),)


def refused(state: State) -> tuple[State, tuple[Event, ...]]:
    raise InputError("not this way.")


def test_changes_pairs_and_savings(ride: Ride, tmp_path: Path):
    """A change is made in the process, between pairs; a state is saved when something happens, and at the end."""
    noise, kept = np.random.default_rng(0).integers(0, 255, (2, 240, 320), np.uint8), tmp_path / "state"
    state = init(ride.rig, Config(every=1000)).but(frame=1)  # so that no pair is looked at
    with Beside(state, keep=kept, keep_every=math.inf) as beside:
        assert beside.ready
        beside.change(partial(seen, folder=tmp_path))
        assert not beside.ready
        beside.change(refused)
        told: list[Event] = []
        until = time.perf_counter() + 120
        while (len(told) < 2 or not beside.ready) and time.perf_counter() < until:
            told.extend(beside.latest()[1])
            time.sleep(0.02)
        assert [event.kind for event in told] == [Kind.HEALTHY, Kind.REFUSED]
        assert told[1].why == "not this way."
        assert int((tmp_path / "seen").read_text()) != os.getpid()
        assert not beside.latest()[0].config.repair
        assert not load(kept).config.repair
        beside.put((noise[0], noise[1]))
        while beside.latest()[0].frame == 1 and time.perf_counter() < until:
            time.sleep(0.02)
        assert load(kept).frame == 1
    assert load(kept).frame == 2


def test_a_share_of_a_core(ride: Ride):
    """A process that has had its share rests, and is not ready; closing does not wait for it."""
    black = np.zeros((240, 320), np.uint8)
    with pytest.raises(InputError, match="above 0"):
        Beside(ride.rig, share=0.0)
    with Beside(ride.rig, share=1e-6) as beside:
        beside.put((black, black))
        until = time.perf_counter() + 120
        while not beside.latest()[1] and time.perf_counter() < until:
            time.sleep(0.02)
        assert not beside.ready
        assert beside.put((black, black))
        assert not beside.put((black, black))
    assert beside.latest()[0].frame == 1
