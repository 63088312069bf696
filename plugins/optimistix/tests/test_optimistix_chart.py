"""The way out of the box, and back in."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_optimistix._chart import chart_at

from stereorecal.strategies import Objective, run_strategy

coordinates = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)
relaxed = settings(deadline=None, max_examples=max(4, settings.default.max_examples // 2))


@relaxed
@given(start=coordinates, v=st.floats(-1e4, 1e4, width=32), step=st.floats(1e-3, 2.0))
def test_no_way_leads_out_of_the_box(start, v, step):
    z = np.asarray(chart_at(start, step)(jnp.full(len(start), v)))
    assert np.abs(z).max() <= 1.0


@relaxed
@given(start=coordinates)
def test_the_way_begins_at_the_start_or_a_little_inside(start):
    z = np.asarray(chart_at(start)(jnp.zeros(len(start))))
    np.testing.assert_allclose(z, np.clip(start, -0.99, 0.99), atol=1e-6)


@relaxed
@given(start=coordinates, goal=st.floats(-1, 1), step=st.floats(1e-2, 2.0))
def test_every_point_of_the_box_is_reached_and_told_apart(start, goal, step):
    chart = chart_at(start, step)
    v = (np.arcsin(goal) - np.asarray(chart.origin, float)) / step
    np.testing.assert_allclose(chart(jnp.asarray(v, jnp.float32)), goal, atol=1e-5)


@relaxed
@given(start=coordinates, step=st.floats(1e-2, 2.0))
def test_the_start_never_lacks_a_slope(start, step):
    slope = np.diag(jax.jacfwd(chart_at(start, step))(jnp.zeros(len(start))))
    np.testing.assert_allclose(slope, step * np.sqrt(1 - np.clip(start, -0.99, 0.99) ** 2), rtol=1e-3)
    assert (slope > 0.1 * step).all()


@pytest.mark.slow(after=6)
@pytest.mark.parametrize("corner", [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0)])
def test_a_corner_is_left(strategy_class, problem, corner):
    run = run_strategy(strategy_class(), Objective(problem(), 1200), np.array(corner))
    assert run.value > 0.1 * run.start_value


def test_a_summit_on_the_border_is_reached(strategy_class, problem):
    run = run_strategy(strategy_class(), Objective(problem((1.0, 0.0, -1.0)), 1200), np.zeros(3))
    assert run.value > 0.05 * run.start_value
    assert np.abs(run.best).max() <= 1.0
