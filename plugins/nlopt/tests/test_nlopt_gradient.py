"""Gradient methods: on the soft count alone, honestly charged, whatever its scale."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import stereorecal_nlopt
from hypothesis import given, settings, strategies as st
from jax.tree_util import Partial

from stereorecal.strategies import Budget, BudgetExhausted, Need, Objective, Problem, Status, Traced, run_strategy

SMOOTH = [c() for c in vars(stereorecal_nlopt).values() if isinstance(c, type) and c.needs is Need.SMOOTH]
each = pytest.mark.parametrize("strategy", SMOOTH, ids=lambda s: type(s).__name__)
DIM = 3
SUMMIT = np.array([0.3, -0.4, 0.1])
CURVATURE = np.array([1.0, 3.0, 10.0])


def bowl(z):
    return 1.0 - (CURVATURE * (z - SUMMIT) ** 2).sum(-1)


def soft(score, *arguments):
    return Problem(DIM, _not_on_the_host, traced=Traced(soft_count=Partial(score, *arguments)))


def _not_on_the_host(points):
    raise AssertionError("it asked for a value on the host")


def run(strategy, problem, budget=None):
    objective = Objective(problem, budget)
    try:
        return strategy.run(objective, np.zeros(DIM), 0), objective
    except BudgetExhausted:
        return None, objective


def scaled(factor, z):
    return factor * bowl(z)


def pocket(z):
    return jnp.where(z[0] > 0.2, jnp.nan, bowl(z))


def kink(z):
    """At the start the value is there, but the gradient is not."""
    return -jnp.sqrt((z**2).sum())


@each
def test_it_climbs_and_charges_every_gradient_once(strategy):
    outcome, objective = run(strategy, soft(bowl))
    trace = objective.trace
    assert outcome.status is Status.CONVERGED
    np.testing.assert_allclose(outcome.best, SUMMIT, atol=0.02)
    assert np.isnan(trace.values).all()
    np.testing.assert_allclose(np.diff(trace.cost, prepend=0.0), DIM + 1)


@each
def test_the_scale_of_the_score_does_not_matter(strategy):
    """A power of two, so that not even rounding differs."""
    traces = [run(strategy, soft(scaled, jnp.float32(factor)))[1].trace for factor in (1.0, 2.0**-20, 2.0**20)]
    for other in traces[1:]:
        np.testing.assert_array_equal(other.points, traces[0].points)


def asked(strategy, score):
    """The points at which the traced score ran."""
    points = []

    def watched(z):
        jax.debug.callback(lambda value: points.append(np.array(value)), z)
        return score(z)

    run(strategy, soft(watched))
    jax.effects_barrier()
    return points


@each
@pytest.mark.parametrize("step", [1 / 32, 1 / 4])
def test_the_first_step_is_the_one_asked_for(strategy, step):
    moved = [np.linalg.norm(point) for point in asked(type(strategy)(step=step), bowl) if point.any()]
    assert 0.75 * step < moved[0] < 1.001 * step  # MMA's asymptotes shorten it


@each
def test_nothing_is_asked_twice_in_a_row(strategy):
    """SLSQP, after a step too long, asks for a value and then for the gradient at the same point."""
    points = asked(type(strategy)(step=2.0), bowl)
    assert all(not np.array_equal(*pair) for pair in pairwise(points))


@each
def test_a_score_without_value_is_never_nominated(strategy):
    outcome, objective = run(strategy, soft(pocket), Budget(400))
    best = objective.trace.points[-1] if outcome is None else outcome.best
    assert 0.1 < best[0] <= 0.2
    np.testing.assert_allclose(best[1:], SUMMIT[1:], atol=0.1)


@each
def test_a_start_without_gradient_ends_at_once(strategy):
    outcome, _ = run(strategy, soft(kink), Budget(400))
    assert outcome.status is Status.STALLED
    assert outcome.message == "the score has no value at any point that was tried"


@settings(deadline=None)
@given(strategy=st.sampled_from(SMOOTH), limit=st.floats(0.5, 100))
def test_stopped_anywhere_it_keeps_the_budget_and_the_best(strategy, limit):
    problem = Problem(DIM, lambda points: bowl(points), traced=Traced(soft_count=Partial(bowl)))
    ended = run_strategy(strategy, Objective(problem, limit), np.zeros(DIM))
    assert ended.trace.total_cost <= limit
    assert ended.value >= max(bowl(ended.trace.points), default=ended.start_value) - 1e-6
    assert ended.value >= ended.start_value
