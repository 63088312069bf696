"""The conformance checks: each takes a strategy and raises AssertionError with a sentence if it fails."""

import pickle
from collections.abc import Callable

import numpy as np

from stereorecal.strategies import (
    AbstractStrategy,
    Budget,
    BudgetExhausted,
    Need,
    Objective,
    Outcome,
    Problem,
    Status,
    StrategyError,
    run_strategy,
)
from stereorecal.testing import _problems

_PLENTY = Budget(evaluations=4000)


def climbs_a_smooth_bowl(strategy: AbstractStrategy) -> None:
    """In 1 and 6 dimensions it climbs most of a smooth bowl."""
    for dim in _dimensions(strategy):
        _assert_climbs(strategy, _problems.bowl(dim), 0.95)


def climbs_a_staircase(strategy: AbstractStrategy) -> None:
    """It climbs a piecewise constant bowl, as counts are."""
    for dim in _dimensions(strategy):
        _assert_climbs(strategy, _problems.staircase(dim), 0.7)


def survives_nan(strategy: AbstractStrategy) -> None:
    """NaN is worse than any value and never nominated."""
    problem = _problems.nan_pocket(max(2, strategy.min_dim))
    outcome = _outcome(strategy, Objective(problem, _PLENTY))
    assert np.isfinite(problem.values(outcome.best[None])).all(), "it nominates a point whose value is NaN"


def ends_on_a_flat_score(strategy: AbstractStrategy) -> None:
    """On a score that is the same everywhere it ends, and the core reports NO_SIGNAL."""
    dim = max(2, strategy.min_dim)
    run = run_strategy(strategy, Objective(_problems.flat(dim)), np.zeros(dim), _PLENTY)
    assert run.status is Status.NO_SIGNAL, f"the run ended as {run.status.name}, not NO_SIGNAL"


def stays_in_the_box(strategy: AbstractStrategy) -> None:
    """Started in a corner, it never asks for a point outside the box (the objective refuses such points)."""
    dim = max(2, strategy.min_dim)
    try:
        outcome = _outcome(strategy, Objective(_problems.bowl(dim), _PLENTY), np.full(dim, 0.999))
    except ValueError as error:
        raise AssertionError(f"it left the box: {error}") from error
    assert np.abs(outcome.best).max() <= 1.0, "it nominates a point outside the box"


def keeps_any_budget(strategy: AbstractStrategy) -> None:
    """Stopped after any number of evaluations, it spends no more, lets BudgetExhausted pass and loses nothing."""
    dim = max(3, strategy.min_dim)
    problem = _problems.bowl(dim)
    for limit in (1, 2, 3, 7, 20):
        counted = _problems.Counted(problem)
        watched = _Watched(counted.problem, Budget(evaluations=limit))
        try:
            strategy.run(watched, np.zeros(dim), watched.budget, 0)
        except BudgetExhausted:
            pass
        else:
            assert not watched.exhaustions, "it swallows BudgetExhausted"
        assert counted.evaluations <= limit, f"it spent {counted.evaluations} of {limit} evaluations"
        assert watched.exhaustions <= 64, "it goes on calling after BudgetExhausted"
        run = run_strategy(strategy, Objective(problem), np.zeros(dim), Budget(evaluations=limit))
        seen = run.trace.values.max(initial=run.start_value)
        assert run.value >= seen, "the best point seen is lost"


def is_honest(strategy: AbstractStrategy) -> None:
    """What it nominates is as good as the best point that it saw."""
    dim = max(3, strategy.min_dim)
    problem = _problems.bowl(dim)
    objective = Objective(problem, _PLENTY)
    outcome = _outcome(strategy, objective)
    value, best = float(problem.values(outcome.best[None])[0]), objective.trace.values.max(initial=-np.inf)
    assert value >= best - 1e-9, f"it nominates a point worth {value} after it saw {best}"


def is_deterministic(strategy: AbstractStrategy) -> None:
    """The same seed gives the same trace."""
    dim = max(3, strategy.min_dim)
    traces = []
    for _ in range(2):
        objective = Objective(_problems.staircase(dim), Budget(evaluations=300))
        _outcome(strategy, objective)
        traces.append(objective.trace.points)
    assert np.array_equal(*traces), "two runs with the same seed differ"


def lets_exceptions_pass(strategy: AbstractStrategy) -> None:
    """An exception of the objective is not swallowed: the core must see it."""
    dim = max(3, strategy.min_dim)
    try:
        run_strategy(strategy, Objective(_problems.failing(dim, after=1)), np.zeros(dim), _PLENTY)
    except (StrategyError, ZeroDivisionError):
        return
    raise AssertionError("it swallows an exception that the objective raised")


def travels(strategy: AbstractStrategy) -> None:
    """It pickles, and its copy is equal: trials run in other processes."""
    assert pickle.loads(pickle.dumps(strategy)) == strategy, "a pickled copy is not equal"


CHECKS: tuple[Callable[[AbstractStrategy], None], ...] = (
    climbs_a_smooth_bowl,
    climbs_a_staircase,
    survives_nan,
    ends_on_a_flat_score,
    stays_in_the_box,
    keeps_any_budget,
    is_honest,
    is_deterministic,
    lets_exceptions_pass,
    travels,
)


class _Watched(Objective):
    """Counts how often it had to say that the budget is used up."""

    exhaustions = 0

    def batch(self, points):
        try:
            return super().batch(points)
        except BudgetExhausted:
            self.exhaustions += 1
            raise


def _dimensions(strategy: AbstractStrategy) -> tuple[int, ...]:
    return tuple(dim for dim in (1, 6) if dim >= strategy.min_dim)


def _assert_climbs(strategy: AbstractStrategy, problem: Problem, share: float) -> None:
    run = run_strategy(strategy, Objective(problem), np.zeros(problem.dim), _PLENTY)
    climbed = (run.value - run.start_value) / (1.0 - run.start_value)
    assert climbed >= share, f"in {problem.dim} dimensions it climbs {climbed:.2f} of the way, not {share}"


def _outcome(strategy: AbstractStrategy, objective: Objective, start: np.ndarray | None = None) -> Outcome:
    assert strategy.needs is Need.HOST, f"the kit has no problems yet for strategies that need {strategy.needs.name}"
    start = np.zeros(objective.dim) if start is None else start
    try:
        return strategy.run(objective, start, objective.budget, 0)
    except BudgetExhausted:
        trace = objective.trace
        return Outcome(trace.points[np.nanargmax(trace.values)], Status.BUDGET)
