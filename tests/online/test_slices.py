"""A repair of a rig that is far off, cut into slices: one for each step, unless time is given."""

import math
from pathlib import Path

import numpy as np
import pytest
from rides import BEFORE, Ride, error

import stereorecal as sr
from stereorecal.online import Config, Kind, State, init, load, save, step
from stereorecal.recordings import Pair

SLICES = 7  # the survey, the count, two rounds at half scale, three at full


@pytest.fixture(scope="module")
def lost(ride: Ride) -> State:
    """So far off that hardly anything matches."""
    off = np.radians([-1.5, 1.0, 2.0, 0.0, 0.0, 0.0])
    rig = ride.rig.with_extrinsics(ride.rig.extrinsics + off)
    return init(rig, Config(prior="exact")).replace(matcher=sr.SAD(num_disparities=48))


def stepped(state: State, pairs: list[Pair], seconds: float | None = None) -> tuple[State, list[Kind]]:
    """Until it is repaired: the state, and what happened."""
    kinds = []
    for pair in pairs:
        state, events = step(state, pair, seconds)
        kinds += [event.kind for event in events]
        if Kind.REPAIRED in kinds:
            return state, kinds
    raise AssertionError(f"no repair: {kinds}")


def test_a_step_does_a_slice(ride: Ride, lost: State):
    state, done, kinds = lost, [], []
    for pair in ride.pairs[BEFORE : BEFORE + 3 + SLICES]:
        state, events = step(state, pair)
        kinds += [event.kind for event in events]
        done += [state.job.done] if state.job is not None else []
        if Kind.REPAIRED in kinds:
            break
    assert done == list(range(SLICES))
    assert kinds == [Kind.REPAIRING, Kind.KNOCK, Kind.REPAIRED]
    assert (error(state, ride.knocked) < [0.05, 0.2, 0.05]).all()


def test_where_nothing_is_switched_no_repair_begins(ride: Ride, lost: State):
    """What moved the rig is said all the same, once."""
    state, kinds = sr.online.freeze(lost), []
    for pair in ride.pairs[BEFORE : BEFORE + 3]:
        state, events = step(state, pair, math.inf)
        kinds += [event.kind for event in events]
    assert kinds == [Kind.KNOCK]
    assert not state.using.any()


@pytest.mark.slow
def test_as_many_as_time_allows(ride: Ride, lost: State):
    """All in the step in which it begins, to the same end."""
    pairs = ride.pairs[BEFORE:]
    at_once, kinds = stepped(lost, pairs, math.inf)
    one_by_one, same = stepped(lost, pairs, 0.0)
    assert kinds == same
    assert at_once.frame == one_by_one.frame - SLICES
    np.testing.assert_array_equal(at_once.using, one_by_one.using)


def test_a_repair_under_way_is_kept(ride: Ride, lost: State, tmp_path: Path):
    state, pairs = lost, ride.pairs[BEFORE:]
    while state.job is None or state.job.done < 3:
        state, _ = step(state, pairs[state.frame])
    save(state, tmp_path / "state")
    ends = [stepped(one, pairs[state.frame :])[0].using for one in (state, load(tmp_path / "state"))]
    np.testing.assert_array_equal(*ends)


def test_freezing_ends_it(ride: Ride, lost: State):
    state, pairs = lost, ride.pairs[BEFORE:]
    while state.job is None:
        state, _ = step(state, pairs[state.frame])
    assert sr.online.freeze(state).job is None
