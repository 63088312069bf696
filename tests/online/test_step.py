"""A ride with a knock: it is noticed, and repaired; and what may never happen."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from json_page import differences
from parts_of_estimates import Measurement
from parts_of_repairs import _moving, _switching
from rides import BEFORE, Ride, error, kinds

import stereorecal as sr
from stereorecal.estimation import Normal
from stereorecal.online import Config, Kind, Stepped, freeze, init, reading, rollback, run, step
from stereorecal.scoring.host import Corners


def test_a_knock_is_noticed_and_repaired(ride: Ride, ridden: list[Stepped]):
    assert kinds(ridden[:BEFORE]) == ["HEALTHY"]
    events = [event for stepped in ridden for event in stepped.events]
    (knock,) = [event for event in events if event.kind is Kind.KNOCK]
    assert knock.frame <= BEFORE + 3
    assert abs(knock.facts["change"]["pitch"] - 0.5) < 0.05
    repairs = [event for event in events if event.kind is Kind.REPAIRED]
    assert knock.frame <= repairs[0].frame <= knock.frame + 2
    for repair in repairs:
        assert repair.facts["proof"]["row_error_after_px"] < repair.facts["proof"]["row_error_before_px"]
    end = ridden[-1].state
    assert (error(end, ride.knocked) < [0.02, 0.1, 0.02]).all()
    assert error(ridden[BEFORE].state, ride.knocked)[0] > 0.4
    assert reading(end).condition is sr.recalibration.Condition.HEALTHY


def test_events_and_readings_are_those_of_the_page(ridden: list[Stepped]):
    """Those of other kinds have no keys of their own."""
    events = [event.as_dict() for stepped in ridden for event in stepped.events]
    (repaired, *_) = [event for event in events if event["event"] == "repaired"]
    told = {"schema": repaired["schema"], **reading(ridden[-1].state).as_dict()}
    unlisted, unwritten = differences([*events, told])
    assert unlisted == set()
    assert unwritten == {"versions.*"}


@pytest.mark.slow
def test_frozen_it_says_so_and_switches_nothing(ride: Ride):
    steps = list(run(ride.rig, ride.pairs, Config(repair=False)))
    assert "KNOCK" in kinds(steps)
    assert "REPAIRED" not in kinds(steps)
    assert not steps[-1].state.using.any()
    assert reading(steps[-1].state).condition is sr.recalibration.Condition.REPAIR


@pytest.mark.slow
def test_rollback_returns_and_stays(ride: Ride, ridden: list[Stepped]):
    state = ridden[-1].state
    back = rollback(state)
    np.testing.assert_array_equal(back.using, state.previous[-1])
    assert not back.config.repair
    assert freeze(back, False).config.repair
    later = list(run(back, ride.pairs[BEFORE : BEFORE + 6]))[-1].state
    np.testing.assert_array_equal(later.using, back.using)
    with pytest.raises(sr.InputError, match="nothing to return to"):
        rollback(init(ride.rig))


def test_rollback_to_one_of_several(ride: Ride):
    one, two, three = (0.1 * number * np.eye(5)[0] for number in (1, 2, 3))
    state = init(ride.rig).replace(using=three, previous=(np.zeros(5), one, two))
    back = rollback(state, one)
    assert np.array_equal(back.using, one)
    assert np.array_equal(back.previous, [np.zeros(5)])
    assert not back.config.repair
    with pytest.raises(sr.InputError, match="has not been in use"):
        rollback(state, three)


@pytest.mark.parametrize("what", ["black", "constant", "nan", "size", "twice"])
def test_a_bad_pair_is_an_event(ride: Ride, ridden: list[Stepped], what: str):
    good = ride.pairs[0]
    pair = {
        "black": (np.zeros((240, 320), np.uint8), np.asarray(good.right)),
        "constant": (np.asarray(good.left), np.full((240, 320), 9, np.uint8)),
        "nan": (np.full((240, 320), np.nan), np.asarray(good.right)),
        "size": (np.asarray(good.left)[:120], np.asarray(good.right)[:120]),
        "twice": (np.asarray(good.left), np.asarray(good.left)),
    }[what]
    state = ridden[BEFORE - 1].state
    after, events = step(state, pair)
    assert [event.kind for event in events] == [Kind.BAD_FRAME]
    assert events[0].why
    assert after.frame == state.frame + 1
    np.testing.assert_array_equal(after.estimate.covariance, state.later().estimate.covariance)
    assert not np.array_equal(after.estimate.covariance, state.estimate.covariance)  # time goes on


def test_bad_pairs_in_a_row_are_said_once_and_end_what_is_followed(ride: Ride):
    black, good = (np.zeros((240, 320), np.uint8),) * 2, ride.pairs[0]
    grid = np.full((40, 2), 20.0)
    state = init(ride.rig).replace(corners=Corners(black[0], grid, grid))
    state, first = step(state, black)
    assert state.corners is None
    state, second = step(state, black)
    assert [event.kind for event in (*first, *second)] == [Kind.BAD_FRAME]
    state, events = step(state.replace(last=step(init(ride.rig), good)[0].last), black)  # after a good one
    assert [event.kind for event in events] == [Kind.BAD_FRAME]


@pytest.mark.slow
def test_open_sea_raises_no_alarm(ride: Ride):
    sea = sr.synthetic.render("open-sea", 3, rig=ride.rig, frames=6).pairs
    steps = list(run(ride.rig, [*ride.pairs[:2], *sea, *ride.pairs[2:BEFORE]]))
    assert not {"KNOCK", "DRIFTING", "REPAIRED", "LATE"} & set(kinds(steps))
    assert not steps[-1].state.using.any()


def test_shutters_that_a_trigger_opens_are_never_late(ride: Ride):
    *_, last = run(ride.rig, ride.pairs[:4], Config(synchronous=True))
    delay = reading(last.state).delay
    assert (delay.low, delay.value, delay.high) == (0.0, 0.0, 0.0)
    assert last.state.seen == 4
    *_, last = run(ride.rig, ride.pairs[:4])
    assert reading(last.state).delay.high > 0.0


def test_a_state_that_is_gone_on_with_a_trigger_knows_no_delay(ride: Ride):
    """Else a delay that was measured would stay for good, and every switch be refused for it."""
    *_, last = run(ride.rig, ride.pairs[:3])
    mean = last.state.estimate.mean.copy()
    mean[-4] = 0.3
    late = last.state.standing_at(replace(last.state.estimate, mean=mean))
    again = late.configured(Config(synchronous=True))
    assert not again.estimate.covariance[-4].any()
    assert not reading(again).late
    assert late.configured(Config(rest=3)).estimate.mean[-4] == 0.3  # nothing was said of the shutters
    back = again.configured(Config())
    assert back.estimate.of_delay == init(ride.rig).estimate.of_delay


def test_a_look_that_fits_a_late_shutter_is_a_knock_of_cameras_with_a_trigger(ride: Ride, ridden: list[Stepped]):
    """A pitch that nobody knew of, while the rig turns by a degree of pitch from pair to pair: in two looks alike."""
    start, told = ridden[BEFORE - 1].state.replace(corners=None), []
    known = start.estimate.covariance.copy()
    known[-4], known[:, -4], known[-4, -4] = 0.0, 0.0, 0.01**2  # of a delay
    start = start.standing_at(replace(start.estimate, covariance=known))
    for synchronous in (False, True):
        state = start.configured(replace(start.config, synchronous=synchronous)).replace(outlier=None)
        pitch = -0.2 * np.eye(len(state.estimate.mean))[0]
        state = state.standing_at(replace(state.estimate, mean=state.estimate.mean + pitch))
        state = state.replace(using=state.using + pitch[:5])
        happened = []
        for pair in ride.pairs[BEFORE - 2 : BEFORE]:
            turned = replace(pair, left=np.roll(pair.left, 6, axis=0))
            between = step(init(ride.rig, Config(every=2)).replace(frame=1), turned)[0]  # is not looked at
            state, events = step(state.replace(last=between.last), pair)
            happened += [event.kind for event in events]
        told.append(happened)
    assert told == [[Kind.LATE], [Kind.KNOCK]]


def test_what_is_no_number_does_not_reach_the_estimate(ride: Ride):
    """Neither of a look nor of a window."""
    state = init(ride.rig)
    normal = Normal(np.eye(len(state.theta)), np.full(len(state.theta), np.nan), 0.0)
    measured = Measurement(normal, np.zeros(3))
    for after in (_switching.followed(state, measured), _moving._after_window(state, measured)):
        assert after.estimate is state.estimate
        assert after.others == state.others


WRONG: tuple[dict[str, Any], ...] = (
    {"heating": (0.0, -1.0, 0.0)},
    {"shift": np.inf},
    {"every": 0},
    {"together": 0},
    {"wander": (0.0, -1.0, 0.0)},
    {"rest": -1},
    {"rest": 1.5},
    {"every": "2"},
    {"repair": "no"},
    {"synchronous": 1},
    {"motion": None},
)


@pytest.mark.usefixtures("unchecked")
def test_tolerances_may_be_given_by_name():
    assert Config(tolerances={"harm": 0.1}).tolerances == sr.Tolerances(harm=0.1)  # pyright: ignore[reportArgumentType]


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("wrong", WRONG)
def test_settings_that_make_no_sense(wrong: dict[str, Any]):
    with pytest.raises(sr.InputError, match=next(iter(wrong))):
        replace(Config(), **wrong)
