"""What a state says of the calibration in use, for offsets that are made up."""

import numpy as np
import pytest

from stereorecal.online import Reading, State, Stepped, reading
from stereorecal.online._switching import nominated
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
    assert not found.travels


def test_a_turn_is_to_be_repaired(healthy):
    found = read(healthy, 0.2, 0.0, 0.0, 0.0, 0.0)
    assert found.condition is Condition.REPAIR
    assert not found.travels
    assert nominated(off_by(healthy, 0.2, 0.0, 0.0, 0.0, 0.0))[0].trial is not None


@pytest.mark.parametrize("turn", [0.0, 0.02])
def test_a_shift_may_be_the_rigs_own_motion(healthy, turn):
    """Though a turn that does not matter is significant beside it."""
    offset = (turn, 0.0, 0.0, 4.0, -5.0)
    found = read(healthy, *offset)
    assert found.shifted
    assert found.condition is Condition.CANNOT_TELL
    assert nominated(off_by(healthy, *offset))[0].trial is None


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
    np.testing.assert_array_equal(after.covariance[:5], np.eye(5, 9))
