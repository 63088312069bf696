"""Wherever the budget ends, the run before it is the same; and every run ends without one."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.strategies import Budget, BudgetExhausted, Need, Objective, Status, Trace, run_strategy

START = np.array([-0.2, 0.1, 0.3])


@cache
def whole_run(strategy_class, problem) -> Trace:
    return run_strategy(strategy_class(), Objective(problem()), START).trace


@pytest.mark.slow(after=3)
@settings(deadline=None, max_examples=max(4, settings.default.max_examples // 10))
@given(limit=st.integers(1, 100))
def test_a_run_that_is_cut_is_the_beginning_of_the_whole_one(strategy_class, problem, limit):
    whole = whole_run(strategy_class, problem)
    cut = run_strategy(strategy_class(), Objective(problem(), limit), START)
    fits = int((whole.cost <= limit).sum())
    np.testing.assert_array_equal(cut.trace.points, whole.points[:fits])
    assert cut.value >= cut.start_value
    assert cut.value >= problem().values(cut.trace.points).max(initial=-np.inf) - 1e-6
    if fits < len(whole.cost):
        assert cut.status is Status.BUDGET


@pytest.mark.slow(after=4)
def test_no_time_no_work(strategy_class, problem):
    objective = Objective(problem(), Budget(seconds=1e-9))
    with pytest.raises(BudgetExhausted):
        strategy_class().run(objective, START, 0)
    assert len(objective.trace.values) == 0


@pytest.mark.slow(after=3)
def test_it_converges_without_a_budget(strategy_class, problem):
    run = run_strategy(strategy_class(), Objective(problem()), START)
    assert run.status is Status.CONVERGED
    assert run.value > 1e-3 * run.start_value


@pytest.mark.slow(after=4)
@pytest.mark.parametrize("steps", [2, 1])
def test_it_ends_after_its_steps(strategy_class, problem, steps):
    run = run_strategy(strategy_class(steps=steps), Objective(problem()), START)
    assert run.status is Status.STALLED
    assert run.message == f"{steps} steps were not enough"
    if strategy_class.needs is not Need.HOST:
        assert run.trace.total_cost == (steps + 1) * (len(START) + 1)


@pytest.mark.slow(after=3)
def test_every_look_is_paid_when_it_is_done(climb_class, problem):
    trace = run_strategy(climb_class(), Objective(problem()), START).trace
    np.testing.assert_array_equal(trace.cost, 4.0 * np.arange(1, len(trace.cost) + 1))


@pytest.mark.slow(after=3)
def test_the_trace_only_ever_gets_better(climb_class, problem):
    bowl = problem()
    trace = run_strategy(climb_class(), Objective(bowl), START).trace
    assert (np.diff(bowl.values(trace.points)) >= -1e-6).all()
