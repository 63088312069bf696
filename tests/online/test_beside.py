"""The spare process: nobody waits for it, and it says what it dropped."""

import os
import time

import numpy as np
import pytest
from rides import Ride

from stereorecal.online import Beside, Event, Kind


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
