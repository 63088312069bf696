"""What a state says of the calibration in use, for offsets that are made up, and what a step makes of that."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from parts_of_repairs import _switching
from rides import Ride, keystone, standing_at

from stereorecal.estimation import points_of_view, readings
from stereorecal.objectives import EXTRINSICS
from stereorecal.online import FAR, Event, Kind, State, Stepped, freeze, init, reading, step
from stereorecal.recalibration import Condition
from stereorecal.synthetic import default_rig

TURNED = (0.2, 0.0, 0.0, 0.0, 0.0)
SIGMA = np.array([0.005, 0.02, 0.005, 0.2, 0.5])


@pytest.fixture
def healthy(ridden: list[Stepped]) -> State:
    """That has seen something everywhere, at all distances."""
    state = ridden[-1].state
    return state.replace(ready=0, coverage=np.ones_like(state.coverage))


def off_by(state: State, *offset: float) -> State:
    return state.replace(estimate=standing_at(state, state.using + offset, np.diag(SIGMA**2)))


@pytest.mark.parametrize(
    ("offset", "condition", "shifted"),
    [
        ((0.0, 0.0, 0.0, 0.0, 0.0), Condition.HEALTHY, False),
        (TURNED, Condition.REPAIR, False),
        ((0.0, 0.0, 0.0, 4.0, -5.0), Condition.REPAIR, True),
        ((0.02, 0.0, 0.0, 4.0, -5.0), Condition.REPAIR, True),  # a turn that does not matter, but is significant
        ((0.3, 0.0, 0.0, 1.0, -1.0), Condition.REPAIR, False),
        ((0.3, 0.0, 0.0, 4.0, -5.0), Condition.REPAIR, True),
    ],
)
def test_a_turn_is_to_be_repaired_and_a_shift_may_be_the_rigs_own_motion(healthy, offset, condition, shifted):
    """It is to be repaired, as `health` says, but not on the word of looks; a turn beside it that is repaired alone may
    cost near rows what it gains far away: then both are, or none."""
    found = reading(off_by(healthy, *offset))
    assert (found.condition, found.shifted) == (condition, shifted)
    assert condition is Condition.HEALTHY or shifted or found.change is not None


def test_a_trigger_leaves_no_shutter_that_a_shift_could_be(healthy):
    state = off_by(healthy, 0.02, 0.0, 0.0, 4.0, -5.0)
    state = state.configured(replace(state.config, synchronous=True))
    found = reading(state)
    assert not found.shifted
    assert found.condition is Condition.REPAIR
    assert found.change is not None
    np.testing.assert_allclose(found.change, state.offset - state.using, atol=0.05)


def unsure_of(state: State, offset: tuple[float, ...], **sigmas: float) -> State:
    """As `off_by`, with other standard deviations of some axes."""
    spread = np.array([sigmas.get(name, sigma) for name, sigma in zip(EXTRINSICS, SIGMA, strict=True)])
    return state.replace(estimate=standing_at(state, state.using + offset, np.diag(spread**2)))


def depth_change_percent(change: np.ndarray) -> float:
    """The change of depth at 30 baselines, straight ahead, by another rotation."""
    return float(100.0 * FAR * np.radians(change[1]))


def test_what_is_not_known_is_neither_repaired_nor_healthy(healthy):
    found = reading(unsure_of(healthy, (0.0,) * 5, pitch=0.3))
    assert found.condition is Condition.CANNOT_TELL
    assert found.change is None


@pytest.mark.parametrize(("yaw", "changes"), [(0.2, True), (0.1, False)])
def test_a_change_may_do_harm_with_a_chance_of_a_fifth(healthy, yaw, changes):
    """It can be taken back; where nothing is switched, neither is asked for, as of a recording."""
    state = unsure_of(healthy, (0.0, yaw, 0.0, 0.0, 0.0), yaw=0.09)
    assert (reading(state).change is not None) is changes
    assert reading(freeze(state)).change is None


def test_depth_is_kept_where_the_yaw_is_not_known(healthy):
    """The pitch is to be repaired; a yaw that may be wrong by more than it corrects hardly changes."""
    found = reading(unsure_of(healthy, (0.2, 0.05, 0.0, 0.0, 0.0), yaw=0.1))
    assert found.change is not None
    assert abs(depth_change_percent(found.change)) < 1.0
    assert found.change[0] == pytest.approx(0.2, abs=0.02)


def test_a_yaw_that_motion_tells_is_repaired(healthy):
    """Its rows are those of a good calibration; depth is ten percent off at 30 baselines. What of the rows is keystone
    is not known, so another yaw may cost rows."""
    state = unsure_of(healthy, (0.0, 0.2, 0.0, 0.0, 0.0), pitch=1e-3, yaw=0.01, roll=1e-3, y=0.01, z=0.05)
    found = reading(state)
    assert found.condition is not Condition.HEALTHY
    assert found.change is not None
    assert found.change[1] == pytest.approx(0.2, abs=0.03)


def expected_loss(state: State) -> float:
    """The expected loss of the calibration in use, in what a matcher notices and points of depth."""
    rng = np.random.default_rng(0)
    loss = []
    for offset in rng.multivariate_normal(state.offset, state.of_offset, 60):
        rows, nearness = readings(state.rig, state.rig_at(offset), points_of_view(state.rig, 30.0, state.view))
        near = max(1.0 + float(np.mean(nearness)), 1e-3)
        loss.append(np.sqrt(np.mean(rows**2)) / 0.05 + abs(100.0 * (1.0 / near - 1.0)))
    return float(np.mean(loss))


@pytest.mark.parametrize("seed", range(6))
def test_what_is_changed(healthy, seed):
    """What is to be repaired is; y and z stay, and what is expected to be lost is less."""
    rng = np.random.default_rng(seed)
    widths = np.array([0.1, 0.3, 0.1, 1.0, 2.0]) * rng.uniform(0.01, 1.0, 5)
    offset = np.array([0.3, 0.5, 0.3, 2.0, 4.0]) * rng.uniform(-1.0, 1.0, 5) * rng.uniform()
    state = unsure_of(healthy, tuple(offset.tolist()), **dict(zip(EXTRINSICS, widths.tolist(), strict=True)))
    found = reading(state)
    change = None if found.shifted else found.change
    assert change is None or found.condition is not Condition.HEALTHY
    if change is not None:
        np.testing.assert_array_equal(change[3:], 0.0)
        assert expected_loss(state.replace(using=state.using + change)) < expected_loss(state)


def test_a_keystone_of_the_lenses_leaves_depth(healthy):
    """A yaw with the principal point that undoes it in depth bends rows as a yaw does."""
    sure, yaw = 1e-8 * np.eye(len(healthy.theta)), np.eye(len(healthy.theta))[1]
    of_bent, of_yaw = (
        reading(healthy.replace(estimate=healthy.estimate.moved(healthy.theta + one, sure)))
        for one in (keystone(healthy), yaw)
    )
    assert abs(of_bent.depth_percent[FAR].value) < 3.0
    assert abs(of_yaw.depth_percent[FAR].value) > 30.0
    assert min(of_bent.rows_px.value, of_yaw.rows_px.value) > 0.1


def test_what_a_turn_alone_repairs_is_no_shift():
    """Though y and z, hardly known, leave the epipolar error above that of a good calibration."""
    state = init(default_rig())
    deviations = np.array([0.01, 0.02, 0.006, 0.9, 0.9])
    found = reading(state.replace(estimate=standing_at(state, [0.0, 1.0, 0.0, 0.0, 0.0], np.diag(deviations**2))))
    assert found.decision.rows_px[1, 0] > found.decision.tolerances.good_rows_px
    assert (found.change is not None, found.shifted) == (True, False)


def test_a_repair_keeps_what_is_known_of_the_shutter(healthy):
    """And of how fast the rig drifts; neither depends on the new offset any more."""
    before = healthy.estimate
    after = before.moved(np.ones(5), np.eye(5))
    np.testing.assert_array_equal(after.mean, [*np.ones(5), *before.mean[5:]])
    np.testing.assert_array_equal(after.covariance[5:, 5:], before.covariance[5:, 5:])
    np.testing.assert_array_equal(after.covariance[:5], np.eye(5, len(before.mean)))


# --- what a step makes of it ----------------------------------------------------------------------------------


@pytest.fixture
def looked(healthy: State, ride: Ride) -> Callable[..., tuple[State, list[Event]]]:
    """looked(*offset, changes, **config): the state after two looks, and what happened, where the calibration in use is
    off by so much; two looks more tell the filter next to nothing."""

    def look(*offset: float, changes: dict[str, Any] | None = None, **config: Any):
        state = healthy.configured(replace(healthy.config, together=10**9, **config))
        truth = state.offset
        state = unsure_of(state.replace(using=truth), (0.0,) * 5).replace(using=truth - offset, **(changes or {}))
        events: list[Event] = []
        for pair in ride.pairs[-2:]:
            state, more = step(state, pair)
            events += more
        return state, events

    return look


SHIFT = (0.02, 0.0, 0.0, 4.0, -5.0)


@pytest.mark.parametrize(
    ("offset", "config", "kinds", "left"),
    [
        (TURNED, {}, [Kind.DRIFTING, Kind.REPAIRED], (0.0,) * 5),
        (TURNED, {"repair": False}, [Kind.DRIFTING], TURNED),
        (SHIFT, {}, [Kind.SHIFTED], SHIFT),
        (SHIFT, {"synchronous": True}, [Kind.DRIFTING, Kind.REPAIRED], (0.0,) * 5),
    ],
    ids=["turn", "frozen", "shift", "shift with a trigger"],
)
def test_what_two_looks_switch(looked, offset, config, kinds, left):
    """The change that the reading asks for; a shift that may be a late shutter's is only said."""
    state, events = looked(*offset, **config)
    assert [event.kind for event in events] == kinds
    np.testing.assert_allclose(state.offset - state.using, left, atol=0.05)
    for event in events:
        if event.kind is Kind.REPAIRED:
            assert event.facts["proof"]["by"] == "looks"
            assert state.ready == event.frame + state.config.rest


def test_a_switch_waits_for_the_rest_and_for_a_turn_that_is_known(looked, healthy):
    """Without the image before, a late shutter could explain all of a look."""
    _, events = looked(*TURNED, changes={"ready": healthy.frame + 2})
    assert [event.kind for event in events] == [Kind.DRIFTING]
    _, (event,) = looked(*TURNED, changes={"last": None, "reported": Kind.DRIFTING})
    assert (event.kind, event.frame) == (Kind.REPAIRED, healthy.frame + 1)


def test_nothing_is_switched_while_a_shutter_is_late(looked, healthy):
    mean, known = healthy.estimate.mean.copy(), healthy.estimate.covariance.copy()
    mean[-4], known[-4], known[:, -4], known[-4, -4] = 0.1, 0.0, 0.0, 1e-4
    late = replace(healthy.estimate, mean=mean, covariance=known)
    _, events = looked(*TURNED, changes={"estimate": late, "reported": Kind.DRIFTING})
    assert [event.kind for event in events] == [Kind.LATE]


def test_a_knock_is_repaired_without_a_rest(ridden, ride):
    before = ridden[-4].state
    state = before.configured(replace(before.config, synchronous=True))
    offset = state.offset - [0.1, 0.0, 0.0, 0.0, 0.0]
    state = state.standing_at(standing_at(state, offset, np.diag(SIGMA**2))).replace(using=offset, ready=99)
    told = []
    for pair in ride.pairs[-3:]:
        state, events = step(state, pair)
        told += [event.kind for event in events]
    assert told == [Kind.KNOCK, Kind.REPAIRED]


def test_the_first_calibration_and_the_last_ones_are_kept(healthy):
    state = healthy.replace(previous=())
    for number in range(1, 12):
        state = _switching.switched(state, np.full(5, float(number)))
    assert [one[0] for one in state.previous] == [healthy.using[0], *range(4, 11)]


@pytest.mark.parametrize(
    ("delay", "sigma", "late"),
    [(0.1, 0.02, True), (-0.1, 0.02, True), (0.1, 0.03, False), (0.029, 0.001, False), (0.031, 0.001, True)],
)
def test_a_shutter_is_late_by_four_standard_errors_and_by_what_matters(healthy, delay, sigma, late):
    mean, known = healthy.estimate.mean.copy(), healthy.estimate.covariance.copy()
    mean[-4], known[-4, -4] = delay, sigma**2
    assert reading(healthy.standing_at(replace(healthy.estimate, mean=mean, covariance=known))).late is late
