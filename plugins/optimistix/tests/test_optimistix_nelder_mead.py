"""Nelder-Mead on the host: what it asks, and what optimistix's own gets wrong."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_optimistix import NelderMead
from stereorecal_optimistix._simplex import distinct

from stereorecal.strategies import Objective, Problem, Status, run_strategy


def test_it_asks_nothing_twice_in_a_row(problem):
    """Optimistix's step evaluates a reflection that it keeps two times."""
    points = run_strategy(NelderMead(), Objective(problem()), np.full(3, -0.5)).trace.points
    assert (points[1:] != points[:-1]).any(axis=1).all()


def test_the_simplex_does_not_collapse(problem):
    """As optimistix's own does, from three dimensions on."""
    run = run_strategy(NelderMead(), Objective(problem((0.4, -0.3, 0.2))), np.zeros(3))
    np.testing.assert_allclose(run.best, [0.4, -0.3, 0.2], atol=0.02)


def test_it_shrinks_towards_its_best_corner():
    """Optimistix's own loses it whenever a corner moves, and ends far from the top of these ridges."""
    slopes = np.array([[1.0, 0.9, 0.0], [0.0, 1.0, 0.9], [0.3, 0.0, 1.0]])
    ridges = Problem(3, lambda points: -np.abs((points - [0.3, -0.2, 0.1]) @ slopes).max(-1))
    run = run_strategy(NelderMead(), Objective(ridges), np.full(3, 0.7))
    assert run.start_value < -0.8
    assert run.value > -0.1


def test_a_plateau_ends_it():
    """A count of four steps: every simplex ties sooner or later."""
    terraces = Problem(3, lambda points: np.floor(4.0 * (1.0 - (points**2).sum(-1))))
    run = run_strategy(NelderMead(), Objective(terraces), np.full(3, 0.7))
    assert run.status is Status.CONVERGED
    assert len(run.trace.values) < 200


@pytest.mark.parametrize("level", [0.0, 1.0, 1e5])
def test_a_flat_score_ends_it_soon(level):
    run = run_strategy(NelderMead(), Objective(Problem(3, lambda points: np.full(len(points), level))), np.zeros(3))
    assert run.status is Status.NO_SIGNAL
    assert len(run.trace.values) < 100


@settings(deadline=None)
@given(values=st.lists(st.sampled_from([0.0, 1.0, -1e5, 1e30]), min_size=1, max_size=12).map(np.array))
def test_ties_are_broken_in_favour_of_the_older(values):
    broken = distinct(values)
    assert np.abs(broken).min() == 0.0 or np.abs(broken).min() >= np.finfo(np.float32).tiny
    assert len(set(broken)) == len(values)
    np.testing.assert_allclose(broken, values, rtol=1e-5, atol=1e-5)
    for i, j in np.argwhere(np.equal.outer(values, values)):
        assert (broken[i] < broken[j]) == (i < j)
