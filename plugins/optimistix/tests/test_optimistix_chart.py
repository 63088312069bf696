"""The way out of the box, and back in."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_optimistix import NelderMead

from stereorecal.strategies import Objective, Problem, run_strategy

coordinates = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)
relaxed = settings(deadline=None, max_examples=max(4, settings.default.max_examples // 2))


def first_asked(start, step: float, evaluations: int) -> np.ndarray:
    """Where a simplex whose edges are so long has asked the score."""
    upwards = Problem(3, lambda points: points.sum(-1))
    return run_strategy(NelderMead(step=step), Objective(upwards, evaluations), start).trace.points


def test_no_way_leads_out_of_the_box():
    """The sum grows upwards, and past the corner if there is a way."""
    asked = first_asked(np.array([1.0, -1.0, 0.5]), 2.0, 80)
    assert np.abs(asked).max() <= 1.0
    assert asked.sum(axis=1).max() > 2.9


@relaxed
@given(start=coordinates, step=st.floats(1e-2, 2.0))
def test_the_way_begins_at_the_start_or_a_little_inside_and_goes_as_far_as_it_is_told(start, step):
    """Along an arc, so that every point of the box is reached and the start never lacks a slope."""
    inside = np.clip(start, -0.99, 0.99)
    aside = np.where(np.eye(3, dtype=bool), np.sin(np.arcsin(inside) + step), inside)
    np.testing.assert_allclose(first_asked(start, step, 4), [inside, *aside], atol=1e-6)


@pytest.mark.slow(after=4)
@pytest.mark.parametrize("corner", [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0)])
def test_a_corner_is_left(strategy_class, problem, corner):
    run = run_strategy(strategy_class(), Objective(problem(), 1200), np.array(corner))
    assert run.value > 0.1 * run.start_value


@pytest.mark.slow(after=4)
def test_a_summit_on_the_border_is_reached(strategy_class, problem):
    run = run_strategy(strategy_class(), Objective(problem((1.0, 0.0, -1.0)), 1200), np.zeros(3))
    assert run.value > 0.05 * run.start_value
    assert np.abs(run.best).max() <= 1.0
