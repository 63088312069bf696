"""What a state says of the calibration in use, for offsets that are made up."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal.online import Kind, Reading, State, Stepped, reading
from stereorecal.online._estimate import Measurement
from stereorecal.online._pair_estimate import PairEstimate
from stereorecal.online._sequential_test import SequentialTest
from stereorecal.online._switching import judged, nominated
from stereorecal.online._watching import followed, standing
from stereorecal.recalibration import Condition

SIGMA = np.array([0.005, 0.02, 0.005, 0.2, 0.5])


@pytest.fixture
def healthy(ridden: list[Stepped]) -> State:
    return ridden[-1].state.but(trial=None, ready=0)


def off_by(state: State, *offset: float) -> State:
    return state.but(estimate=state.estimate.moved(state.using + offset, np.diag(SIGMA**2)))


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


@pytest.mark.parametrize("by", ["looks", "repair"])
def test_a_repair_may_move_y_and_z(healthy, by):
    """It was judged by its own misfit; a candidate of looks is dropped."""
    state = off_by(healthy, 0.0, 0.0, 0.0, 4.0, -5.0)
    state = state.but(trial=SequentialTest(state.estimate.offset, by, state.frame - 1))
    look = PairEstimate(state.chart, 0.5)
    after, _ = judged(state, Measurement(state.frame, state.estimate.offset, np.diag(SIGMA**-2.0), np.zeros(5)), look)
    assert (after.trial is not None) is (by == "repair")


@pytest.mark.parametrize("pitch", [0.9, 1.1])
def test_significant_is_one_in_ten_thousand(healthy, pitch):
    """Of five numbers: 5.07 standard errors of one."""
    found = reading(off_by(healthy.but(steepness=1e6 * np.eye(5)), pitch * 5.07 * SIGMA[0], 0.0, 0.0, 0.0, 0.0))
    assert found.matters
    assert (found.condition is Condition.REPAIR) is (pitch > 1.0)


def test_what_is_no_number_is_not_healthy(healthy):
    broken = healthy.but(estimate=replace(healthy.estimate, mean=healthy.estimate.mean * np.nan))
    assert reading(broken).condition is Condition.CANNOT_TELL


def test_after_a_knock_nothing_that_came_before_is_on_trial(healthy):
    """Not even where too little is known to say that it was one."""
    state = healthy.but(trial=SequentialTest(healthy.using + 0.01, "looks", 0), ready=99, suspect=None)
    for frame in (1, 2):
        far = Measurement(frame, healthy.using + np.array([0.0, 2.0, 0.0, 0.0, 0.0]), np.diag(SIGMA**-2.0), np.zeros(5))
        state, _ = followed(state, far)
    assert state.trial is None
    assert state.ready == 0


def test_a_shift_beside_a_turn_that_matters(healthy):
    found = read(healthy, 0.3, 0.0, 0.0, 4.0, -5.0)
    assert found.condition is Condition.REPAIR
    assert not found.shifted


def test_a_repair_keeps_what_is_known_of_the_shutter(healthy):
    """And of how fast the rig drifts; neither depends on the new offset any more."""
    before = healthy.estimate
    after = before.moved(np.ones(5), np.eye(5))
    np.testing.assert_array_equal(after.mean, [*np.ones(5), *before.mean[5:]])
    np.testing.assert_array_equal(after.covariance[5:, 5:], before.covariance[5:, 5:])
    np.testing.assert_array_equal(after.covariance[:5], np.eye(5, 11))
