"""What a state says of the calibration in use, for offsets that are made up."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal.estimation import points_of_view, readings
from stereorecal.online import FAR, Kind, Reading, State, Stepped, reading
from stereorecal.online._filter import KEYSTONE, Measurement
from stereorecal.online._pair_estimate import PairEstimate
from stereorecal.online._sequential_test import SequentialTest
from stereorecal.online._switching import decided, nominated, trial_after_look
from stereorecal.online._watching import followed, standing
from stereorecal.recalibration import Condition

TURNED = (0.2, 0.0, 0.0, 0.0, 0.0)
SIGMA = np.array([0.005, 0.02, 0.005, 0.2, 0.5])


@pytest.fixture
def healthy(ridden: list[Stepped]) -> State:
    return ridden[-1].state.replace(trial=None, ready=0)


def off_by(state: State, *offset: float) -> State:
    return state.replace(estimate=state.estimate.moved(state.using + offset, np.diag(SIGMA**2)))


def read(state: State, *offset: float) -> Reading:
    return reading(off_by(state, *offset))


def test_nothing(healthy):
    found = read(healthy, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert found.condition is Condition.HEALTHY
    assert not found.shifted


def test_a_turn_is_to_be_repaired(healthy):
    found = read(healthy, 0.2, 0.0, 0.0, 0.0, 0.0)
    assert found.condition is Condition.REPAIR
    assert not found.shifted
    assert nominated(off_by(healthy, 0.2, 0.0, 0.0, 0.0, 0.0))[0].trial is not None


@pytest.mark.parametrize("turn", [0.0, 0.02])
def test_a_shift_may_be_the_rigs_own_motion(healthy, turn):
    """Though a turn that does not matter is significant beside it. It is to be repaired, as `health` says, but not on
    the word of looks."""
    state = off_by(healthy, turn, 0.0, 0.0, 4.0, -5.0)
    found = reading(state)
    assert found.shifted
    assert found.condition is Condition.REPAIR
    assert nominated(state)[0].trial is None
    assert standing(state)[1][0].kind is Kind.SHIFTED


def test_a_trigger_leaves_no_shutter_that_a_shift_could_be(healthy):
    state = off_by(healthy, 0.02, 0.0, 0.0, 4.0, -5.0)
    state = state.configured(replace(state.config, synchronous=True))
    found = reading(state)
    assert not found.shifted
    assert found.condition is Condition.REPAIR
    trial = nominated(state)[0].trial
    assert trial is not None
    np.testing.assert_allclose(trial.offset - state.using, state.estimate.offset - state.using, atol=0.02)
    assert standing(state)[1][0].kind is Kind.DRIFTING


@pytest.mark.parametrize("by", ["looks", "repair"])
def test_a_repair_may_move_y_and_z(healthy, by):
    """It was judged by its own misfit; a candidate of looks is dropped."""
    state = off_by(healthy, 0.0, 0.0, 0.0, 4.0, -5.0)
    state = state.replace(trial=SequentialTest(state.estimate.offset, by, state.frame - 1))
    look = PairEstimate(state.chart, 0.5)
    after, _ = trial_after_look(
        state, Measurement(state.frame, state.estimate.offset, np.diag(SIGMA**-2.0), np.zeros(5)), look
    )
    assert (after.trial is not None) is (by == "repair")


def unsure_of(state: State, offset: tuple[float, ...], **sigmas: float) -> State:
    """As `off_by`, with other standard deviations of some axes."""
    spread = np.array([sigmas.get(name, sigma) for name, sigma in zip(state.chart.names, SIGMA, strict=True)])
    return state.replace(estimate=state.estimate.moved(state.using + offset, np.diag(spread**2)))


def depth_change_percent(state: State, offset: np.ndarray) -> float:
    """Of depth at 30 baselines, straight ahead, by another rotation."""
    yaw = np.radians(offset[1] - state.using[1])
    return float(100.0 * FAR * yaw)


def test_what_is_not_known_is_neither_repaired_nor_healthy(healthy):
    state = unsure_of(healthy, (0.0,) * 5, pitch=0.3)
    assert reading(state).condition is Condition.CANNOT_TELL
    assert nominated(state)[0].trial is None


def test_what_is_better_on_average_goes_on_trial(healthy):
    """It is not said to be a repair: later looks must bear it out."""
    state = unsure_of(healthy, (0.0, 0.2, 0.0, 0.0, 0.0), yaw=0.09)
    assert not reading(state).repairs
    trial = nominated(state)[0].trial
    assert trial is not None
    assert trial.offset[1] - state.using[1] == pytest.approx(0.2, abs=0.03)


def test_what_is_better_on_average_and_may_well_harm_does_not(healthy):
    state = unsure_of(healthy, (0.0, 0.1, 0.0, 0.0, 0.0), yaw=0.1)
    assert reading(state).change is None
    assert nominated(state)[0].trial is None
    braver = state.replace(config=replace(state.config, harm=0.4))
    assert nominated(braver)[0].trial is not None


@pytest.mark.parametrize(("sigma", "switches"), [(0.1, False), (0.02, True)])
def test_a_trial_that_is_won_needs_what_the_filter_knows(healthy, sigma, switches):
    """Looks of one place err together: by themselves they are surer than all of them are."""
    state = unsure_of(healthy, (0.0, 0.1, 0.0, 0.0, 0.0), yaw=sigma)
    won = SequentialTest(state.estimate.offset, "looks", state.frame - 1, looks=9, matches=20.0)
    assert won.won(state.config.switch)
    after, events = decided(state.replace(trial=won))
    (event,) = events
    assert event.kind is (Kind.REPAIRED if switches else Kind.REJECTED)
    assert (event.facts["proof"]["chance_of_harm"] <= state.config.harm) is switches
    assert np.array_equal(after.using, won.offset if switches else state.using)


def test_a_trial_on_what_is_no_number_switches_nothing(healthy):
    won = SequentialTest(healthy.using + 0.1, "repair", healthy.frame - 1, looks=9, matches=20.0)
    unknown = healthy.standing_at(replace(healthy.estimate, mean=np.full_like(healthy.estimate.mean, np.nan)))
    after, events = decided(unknown.replace(trial=won))
    assert [event.kind for event in events] == [Kind.REJECTED]
    assert np.array_equal(after.using, healthy.using)


def test_depth_is_kept_where_the_yaw_is_not_known(healthy):
    """The pitch is to be repaired; a yaw that may be wrong by more than it corrects stays."""
    state = unsure_of(healthy, (0.2, 0.05, 0.0, 0.0, 0.0), yaw=0.1)
    found = reading(state)
    assert found.decision is not None
    assert found.decision.keeps_depth
    trial = nominated(state)[0].trial
    assert trial is not None
    assert abs(depth_change_percent(state, trial.offset)) < 0.3
    assert trial.offset[0] - state.using[0] == pytest.approx(0.2, abs=0.02)


def test_a_yaw_that_motion_tells_goes_on_trial(healthy):
    """Its rows are those of a good calibration; depth is ten percent off at 30 baselines. What of the rows is keystone
    is not known, so another yaw may cost rows."""
    state = unsure_of(healthy, (0.0, 0.2, 0.0, 0.0, 0.0), pitch=1e-3, yaw=0.01, roll=1e-3, y=0.01, z=0.05)
    assert reading(state).condition is not Condition.HEALTHY
    trial = nominated(state)[0].trial
    assert trial is not None
    assert trial.offset[1] - state.using[1] == pytest.approx(0.2, abs=0.03)


def expected_loss(state: State) -> float:
    """Of the calibration in use, in what a matcher notices and points of depth."""
    rng = np.random.default_rng(0)
    loss = []
    for offset in rng.multivariate_normal(state.estimate.offset, state.estimate.of_offset, 60):
        rows, nearness = readings(state.rig, state.rig_at(offset), points_of_view(state.rig, 30.0, state.view))
        near = max(1.0 + float(np.mean(nearness)), 1e-3)
        loss.append(np.sqrt(np.mean(rows**2)) / 0.05 + abs(100.0 * (1.0 / near - 1.0)))
    return float(np.mean(loss))


@pytest.mark.parametrize("seed", range(12))
def test_what_is_on_trial(healthy, seed):
    """What is to be repaired is; y and z stay, and what is expected to be lost is less."""
    rng = np.random.default_rng(seed)
    widths = np.array([0.1, 0.3, 0.1, 1.0, 2.0]) * rng.uniform(0.01, 1.0, 5)
    offset = np.array([0.3, 0.5, 0.3, 2.0, 4.0]) * rng.uniform(-1.0, 1.0, 5) * rng.uniform()
    state = unsure_of(healthy, tuple(offset.tolist()), **dict(zip(healthy.chart.names, widths.tolist(), strict=True)))
    found, trial = reading(state), nominated(state)[0].trial
    assert trial is not None or found.shifted or not found.repairs
    assert trial is None or found.condition is not Condition.HEALTHY
    if trial is not None:
        np.testing.assert_array_equal(trial.offset[3:], state.using[3:])
        assert expected_loss(state.using_now(trial.offset)) < expected_loss(state)


def test_a_keystone_bends_rows_and_leaves_depth(healthy):
    """It is a yaw of the rows alone: what intrinsics leave."""
    known = healthy.estimate.moved(healthy.using, 1e-8 * np.eye(5))
    mean, covariance = known.mean.copy(), known.covariance.copy()
    mean[KEYSTONE], covariance[KEYSTONE], covariance[:, KEYSTONE] = 1.0, 0.0, 0.0
    bent = reading(healthy.replace(estimate=replace(known, mean=mean, covariance=covariance)))
    yaw = known.moved(healthy.using + np.array([0.0, 1.0, 0.0, 0.0, 0.0]), 1e-8 * np.eye(5))
    turned = reading(healthy.replace(estimate=yaw))
    assert abs(bent.depth_percent[FAR].value) < 1.0
    assert abs(turned.depth_percent[FAR].value) > 30.0
    assert bent.rows_px.value == pytest.approx(turned.rows_px.value, rel=0.2)


def test_what_is_no_number_is_not_healthy(healthy):
    broken = healthy.replace(estimate=replace(healthy.estimate, mean=healthy.estimate.mean * np.nan))
    assert reading(broken).condition is Condition.CANNOT_TELL


def test_after_a_knock_nothing_that_came_before_is_on_trial(healthy):
    """Not even where too little is known to say that it was one."""
    state = healthy.replace(trial=SequentialTest(healthy.using + 0.01, "looks", 0), ready=99, outlier=None)
    for frame in (1, 2):
        far = Measurement(frame, healthy.using + np.array([0.0, 2.0, 0.0, 0.0, 0.0]), np.diag(SIGMA**-2.0), np.zeros(5))
        state, _ = followed(state, far)
    assert state.trial is None
    assert state.ready == 0


@pytest.mark.parametrize(("y", "z", "shifted"), [(1.0, -1.0, False), (4.0, -5.0, True)])
def test_a_shift_beside_a_turn(healthy, y, z, shifted):
    """A turn that is repaired alone may cost near rows what it gains far away: then both are, or none."""
    found = read(healthy, 0.3, 0.0, 0.0, y, z)
    assert found.condition is Condition.REPAIR
    assert found.shifted is shifted


def test_a_repair_keeps_what_is_known_of_the_shutter(healthy):
    """And of how fast the rig drifts; neither depends on the new offset any more."""
    before = healthy.estimate
    after = before.moved(np.ones(5), np.eye(5))
    np.testing.assert_array_equal(after.mean, [*np.ones(5), *before.mean[5:]])
    np.testing.assert_array_equal(after.covariance[5:, 5:], before.covariance[5:, 5:])
    np.testing.assert_array_equal(after.covariance[:5], np.eye(5, 11))
