"""What a state says of the calibration in use, for offsets that are made up, and what a step makes of that."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rides import Ride

from stereorecal.decision import Tolerances
from stereorecal.estimation import points_of_view, readings
from stereorecal.online import FAR, Event, Kind, State, Stepped, init, reading, step
from stereorecal.recalibration import Condition
from stereorecal.synthetic import default_rig

TURNED = (0.2, 0.0, 0.0, 0.0, 0.0)
SIGMA = np.array([0.005, 0.02, 0.005, 0.2, 0.5])


@pytest.fixture
def healthy(ridden: list[Stepped]) -> State:
    return ridden[-1].state.replace(trial=None, ready=0)


def off_by(state: State, *offset: float) -> State:
    return state.replace(estimate=state.estimate.moved(state.using + offset, np.diag(SIGMA**2)))


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
    np.testing.assert_allclose(found.change, state.estimate.offset - state.using, atol=0.05)


def unsure_of(state: State, offset: tuple[float, ...], **sigmas: float) -> State:
    """As `off_by`, with other standard deviations of some axes."""
    spread = np.array([sigmas.get(name, sigma) for name, sigma in zip(state.chart.names, SIGMA, strict=True)])
    return state.replace(estimate=state.estimate.moved(state.using + offset, np.diag(spread**2)))


def depth_change_percent(change: np.ndarray) -> float:
    """Of depth at 30 baselines, straight ahead, by another rotation."""
    return float(100.0 * FAR * np.radians(change[1]))


def test_what_is_not_known_is_neither_repaired_nor_healthy(healthy):
    found = reading(unsure_of(healthy, (0.0,) * 5, pitch=0.3))
    assert found.condition is Condition.CANNOT_TELL
    assert found.change is None


def test_what_is_better_on_average_goes_on_trial(healthy):
    """It is not said to be a repair: later looks must bear it out."""
    found = reading(unsure_of(healthy, (0.0, 0.2, 0.0, 0.0, 0.0), yaw=0.09))
    assert not found.repairs
    assert found.change is not None
    assert found.change[1] == pytest.approx(0.2, abs=0.03)


def test_what_is_better_on_average_and_may_well_harm_does_not(healthy):
    state = unsure_of(healthy, (0.0, 0.1, 0.0, 0.0, 0.0), yaw=0.1)
    assert reading(state).change is None
    braver = state.replace(config=replace(state.config, harm=0.4))
    assert reading(braver).change is not None


def test_depth_is_kept_where_the_yaw_is_not_known(healthy):
    """The pitch is to be repaired; a yaw that may be wrong by more than it corrects hardly changes."""
    found = reading(unsure_of(healthy, (0.2, 0.05, 0.0, 0.0, 0.0), yaw=0.1))
    assert found.change is not None
    assert abs(depth_change_percent(found.change)) < 1.0
    assert found.change[0] == pytest.approx(0.2, abs=0.02)


def test_a_yaw_that_motion_tells_goes_on_trial(healthy):
    """Its rows are those of a good calibration; depth is ten percent off at 30 baselines. What of the rows is keystone
    is not known, so another yaw may cost rows."""
    state = unsure_of(healthy, (0.0, 0.2, 0.0, 0.0, 0.0), pitch=1e-3, yaw=0.01, roll=1e-3, y=0.01, z=0.05)
    found = reading(state)
    assert found.condition is not Condition.HEALTHY
    assert found.change is not None
    assert found.change[1] == pytest.approx(0.2, abs=0.03)


def expected_loss(state: State) -> float:
    """Of the calibration in use, in what a matcher notices and points of depth."""
    rng = np.random.default_rng(0)
    loss = []
    for offset in rng.multivariate_normal(state.estimate.offset, state.estimate.of_offset, 60):
        rows, nearness = readings(state.rig, state.rig_at(offset), points_of_view(state.rig, 30.0, state.view))
        near = max(1.0 + float(np.mean(nearness)), 1e-3)
        loss.append(np.sqrt(np.mean(rows**2)) / 0.05 + abs(100.0 * (1.0 / near - 1.0)))
    return float(np.mean(loss))


@pytest.mark.parametrize("seed", range(6))
def test_what_is_on_trial(healthy, seed):
    """What is to be repaired is; y and z stay, and what is expected to be lost is less."""
    rng = np.random.default_rng(seed)
    widths = np.array([0.1, 0.3, 0.1, 1.0, 2.0]) * rng.uniform(0.01, 1.0, 5)
    offset = np.array([0.3, 0.5, 0.3, 2.0, 4.0]) * rng.uniform(-1.0, 1.0, 5) * rng.uniform()
    state = unsure_of(healthy, tuple(offset.tolist()), **dict(zip(healthy.chart.names, widths.tolist(), strict=True)))
    found = reading(state)
    change = None if found.shifted else found.change
    assert change is not None or found.shifted or not found.repairs
    assert change is None or found.condition is not Condition.HEALTHY
    if change is not None:
        np.testing.assert_array_equal(change[3:], 0.0)
        assert expected_loss(state.using_now(state.using + change)) < expected_loss(state)


def test_a_keystone_bends_rows_and_leaves_depth(healthy):
    """It is a yaw of the rows alone: what intrinsics leave."""
    known = healthy.estimate.moved(healthy.using, 1e-8 * np.eye(5))
    mean, covariance = known.mean.copy(), known.covariance.copy()
    mean[9], covariance[9], covariance[:, 9] = 1.0, 0.0, 0.0
    state = healthy.replace(estimate=replace(known, mean=mean, covariance=covariance))
    assert state.estimate.keystone == 1.0
    bent = reading(state)
    yaw = known.moved(healthy.using + np.array([0.0, 1.0, 0.0, 0.0, 0.0]), 1e-8 * np.eye(5))
    turned = reading(healthy.replace(estimate=yaw))
    assert abs(bent.depth_percent[FAR].value) < 1.0
    assert abs(turned.depth_percent[FAR].value) > 30.0
    assert bent.rows_px.value == pytest.approx(turned.rows_px.value, rel=0.2)


def test_what_is_no_number_is_not_healthy(healthy):
    broken = healthy.replace(estimate=replace(healthy.estimate, mean=healthy.estimate.mean * np.nan))
    assert reading(broken).condition is Condition.CANNOT_TELL


def test_what_a_turn_alone_repairs_is_no_shift():
    """Though y and z, hardly known, leave the epipolar error above that of a good calibration."""
    state = init(default_rig())
    deviations = np.full(len(state.estimate.mean), 1e-3)
    deviations[:5], deviations[9] = [0.01, 0.02, 0.006, 0.7, 0.7], 0.2  # and the keystone
    estimate = replace(state.estimate, mean=np.eye(len(deviations))[1], covariance=np.diag(deviations**2))
    found = reading(state.replace(estimate=estimate))
    assert found.decision.rows_px[1, 0] > found.decision.tolerances.good_rows_px
    assert (found.repairs, found.shifted) == (True, False)


def test_a_repair_keeps_what_is_known_of_the_shutter(healthy):
    """And of how fast the rig drifts; neither depends on the new offset any more."""
    before = healthy.estimate
    after = before.moved(np.ones(5), np.eye(5))
    np.testing.assert_array_equal(after.mean, [*np.ones(5), *before.mean[5:]])
    np.testing.assert_array_equal(after.covariance[5:, 5:], before.covariance[5:, 5:])
    np.testing.assert_array_equal(after.covariance[:5], np.eye(5, 11))


# --- what a step makes of it ----------------------------------------------------------------------------------


@pytest.fixture
def begun(ridden: list[Stepped]):
    """A trial without any look yet."""
    return next(one.state.trial for one in ridden if one.state.trial is not None)


@pytest.fixture
def looked(healthy: State, begun, ride: Ride) -> Callable[..., tuple[State, tuple[Event, ...]]]:
    """looked(*offset, trial, config, axis=sigma...): the state after a look at the last pair, and what happened, where
    the calibration in use is off by so much; one look more tells the filter next to nothing."""

    def look(*offset: float, trial: dict[str, Any] | None = None, config: dict[str, Any] | None = None, **sigmas):
        state = healthy.configured(replace(healthy.config, together=10**9, **(config or {})))
        truth = state.estimate.offset
        state = unsure_of(state.using_now(truth), (0.0,) * 5, **sigmas).using_now(truth - offset)
        if trial is not None:
            state = state.replace(trial=replace(begun, offset=truth, since=state.frame - 1, **trial))
        return step(state, ride.pairs[-1])

    return look


SHIFT = (0.02, 0.0, 0.0, 4.0, -5.0)


@pytest.mark.parametrize(
    ("offset", "config", "kind", "change"),
    [
        (TURNED, {}, Kind.DRIFTING, TURNED),
        (TURNED, {"repair": False}, Kind.DRIFTING, None),
        (SHIFT, {}, Kind.SHIFTED, None),
        (SHIFT, {"synchronous": True}, Kind.DRIFTING, SHIFT),
    ],
    ids=["turn", "frozen", "shift", "shift with a trigger"],
)
def test_what_a_look_puts_on_trial(looked, offset, config, kind, change):
    """The change that the reading asks for; a shift that may be a late shutter's is only said."""
    state, events = looked(*offset, config=config)
    assert [event.kind for event in events] == [kind]
    assert (state.trial is not None) is (change is not None)
    if change is not None:
        assert (state.trial.by, state.trial.since) == ("looks", state.frame - 1)
        np.testing.assert_allclose(state.trial.offset - state.using, change, atol=0.05)


@pytest.mark.parametrize("by", ["looks", "repair"])
def test_a_repair_may_move_y_and_z(looked, by):
    """It was judged by its own misfit; a candidate of looks is dropped."""
    state, _ = looked(0.0, 0.0, 0.0, 4.0, -5.0, trial={"by": by})
    assert (state.trial is not None) is (by == "repair")


WON = {"looks": 9, "matches": 20.0, "rows_before": 1.0}


@pytest.mark.parametrize(("sigma", "switches"), [(0.1, False), (0.02, True)])
def test_a_trial_that_is_won_needs_what_the_filter_knows(looked, sigma, switches):
    """Looks of one place err together: by themselves they are surer than all of them are."""
    state, events = looked(0.0, 0.1, 0.0, 0.0, 0.0, trial={"by": "looks", **WON}, yaw=sigma)
    (event,) = (one for one in events if "proof" in one.facts)
    proof = event.facts["proof"]
    assert proof["log_likelihood_ratio"] > 10.0
    assert proof["row_error_after_px"] < proof["row_error_before_px"]
    assert event.kind is (Kind.REPAIRED if switches else Kind.REJECTED)
    assert (proof["chance_of_harm"] <= state.config.harm) is switches
    left = -0.1 * np.eye(5)[1] if not switches else np.zeros(5)
    np.testing.assert_allclose(state.using - state.estimate.offset, left, atol=1e-3)


def test_a_trial_on_what_is_no_number_switches_nothing(healthy, begun, ride):
    """Where nothing matches any more, it is won by what was seen before."""
    won = replace(begun, offset=healthy.using + 0.1, since=healthy.frame - 1, **WON)
    unknown = healthy.standing_at(replace(healthy.estimate, mean=np.full_like(healthy.estimate.mean, np.nan)))
    pair = ride.pairs[-1]
    after, events = step(unknown.replace(trial=won), replace(pair, right=np.roll(pair.right, 60, axis=0)))
    assert [event.kind for event in events] == [Kind.REJECTED]
    assert events[0].facts["proof"]["log_likelihood_ratio"] > 10.0
    assert np.array_equal(after.using, healthy.using)


@pytest.mark.parametrize("good_rows_px", [0.05, 50.0])
def test_after_a_knock_nothing_that_came_before_is_on_trial(ridden, begun, ride, good_rows_px):
    """Not even where it is too small to be told."""
    before = ridden[-3].state
    state = before.configured(
        replace(before.config, synchronous=True, tolerances=Tolerances(good_rows_px=good_rows_px))
    )
    offset = state.estimate.offset - [0.1, 0.0, 0.0, 0.0, 0.0]
    state = state.standing_at(state.estimate.moved(offset, np.diag(SIGMA**2))).using_now(offset)
    state, told = state.replace(trial=replace(begun, offset=offset + 0.01, since=0), ready=99), []
    for pair in ride.pairs[-2:]:
        state, events = step(state, pair)
        told += [event.kind for event in events]
    assert (Kind.KNOCK in told) is (good_rows_px < 1.0)
    assert state.ready == 0
    assert state.trial is None or state.trial.since == state.frame - 1


@pytest.mark.parametrize(
    ("delay", "sigma", "late"),
    [(0.1, 0.02, True), (-0.1, 0.02, True), (0.1, 0.03, False), (0.029, 0.001, False), (0.031, 0.001, True)],
)
def test_a_shutter_is_late_by_four_standard_errors_and_by_what_matters(healthy, delay, sigma, late):
    mean, known = healthy.estimate.mean.copy(), healthy.estimate.covariance.copy()
    mean[5], known[5, 5] = delay, sigma**2
    assert reading(healthy.standing_at(replace(healthy.estimate, mean=mean, covariance=known))).late is late
