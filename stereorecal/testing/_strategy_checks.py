"""The conformance kit of strategies: each check raises AssertionError with a sentence if the strategy fails it."""

import pickle
from collections.abc import Callable
from functools import lru_cache
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.matching import SAD
from stereorecal.objectives import Reach, count_chart, objective
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
from stereorecal.synthetic import default_rig, render
from stereorecal.testing import _analytic_problems as problems
from stereorecal.testing._analytic_problems import problem
from stereorecal.testing._checks import Check, CheckResult, Checks

_PLENTY = Budget(evaluations=2000)  # our choice: ample for these problems, and every run ends
_SIZE = (160, 120)
_REACH = Reach(degrees=1.0, baseline_fraction=0.01)
_TRUTH = np.array([0.45, -0.3, 0.4, 0.3, -0.2])  # relative to the start, in units of the reach; our choice


STRATEGY_CHECKS = Checks()


def _check_for(*needs: Need) -> Callable[[Check], Check]:
    """Decorate a check of strategies with one of these needs."""
    return STRATEGY_CHECKS.add(lambda strategy: strategy.needs in needs)


_SCORES = (Need.HOST, Need.SMOOTH)
_ANALYTIC = (*_SCORES, Need.RESIDUALS)


@_check_for(*_ANALYTIC)
def climbs_a_smooth_bowl(strategy: AbstractStrategy) -> None:
    """It climbs most of a smooth bowl, in the fewest and in the most dimensions (1 to 6) that it takes."""
    for dim in _dimensions(strategy):
        _assert_climbs(strategy, _bowl(strategy, dim), 0.9)


@_check_for(*_SCORES)
def climbs_a_staircase(strategy: AbstractStrategy) -> None:
    """It climbs a piecewise constant bowl, as a count is; a strategy that needs a smooth score gets the smooth bowl."""
    for dim in _dimensions(strategy):
        _assert_climbs(strategy, problem(problems.staircase, dim), 0.7)


@_check_for(*_SCORES)
def climbs_a_tilted_ridge(strategy: AbstractStrategy) -> None:
    """It climbs most of a ridge along the diagonal, oblique to every axis."""
    _assert_climbs(strategy, problem(problems.tilted_ridge, _at_least(strategy, 3)), 0.7)


@_check_for(*_SCORES)
def keeps_off_a_cliff(strategy: AbstractStrategy) -> None:
    """It climbs a bowl that drops to a plateau on one side."""
    _assert_climbs(strategy, problem(problems.cliff, _at_least(strategy, 2)), 0.7)


@_check_for(*_SCORES)
def climbs_a_noisy_bowl(strategy: AbstractStrategy) -> None:
    """It climbs a bowl with ripples, none higher than a twentieth of the climb."""
    _assert_climbs(strategy, problem(problems.noisy_bowl, _at_least(strategy, 3)), 0.5)


@_check_for(Need.RESIDUALS)
def solves_a_curved_valley(strategy: AbstractStrategy) -> None:
    """It solves Rosenbrock's valley as a least-squares problem."""
    _assert_climbs(strategy, problem(problems.curved, _at_least(strategy, 2)), 0.99)


@_check_for(*_ANALYTIC)
def survives_nan(strategy: AbstractStrategy) -> None:
    """It treats NaN as worse than any value and never nominates such a point."""
    pocket = _problem_of(strategy, problems.nan_pocket, _at_least(strategy, 2))
    outcome = _outcome(strategy, Objective(pocket, _PLENTY))
    assert np.isfinite(pocket.values(outcome.best[None])).all(), "it nominates a point whose value is NaN"


@_check_for(*_ANALYTIC)
def ends_on_a_flat_score(strategy: AbstractStrategy) -> None:
    """It ends on a constant score; where the core sees the values, the run is reported as NO_SIGNAL."""
    dim = _at_least(strategy, 2)
    run = run_strategy(strategy, Objective(_problem_of(strategy, problems.flat, dim), _PLENTY), np.zeros(dim))
    if strategy.needs is Need.HOST:
        assert run.status is Status.NO_SIGNAL, f"the run ended as {run.status.name}, not NO_SIGNAL"


@_check_for(*_ANALYTIC)
def stays_in_the_box(strategy: AbstractStrategy) -> None:
    """Started in a corner, it never evaluates a point outside the box."""
    dim, meter = _at_least(strategy, 2), problems.Meter()
    try:
        outcome = _outcome(strategy, Objective(_bowl(strategy, dim, meter), _PLENTY), np.full(dim, 1.0))
    except ValueError as error:
        raise AssertionError(f"it leaves the box: {error}") from error
    assert meter.farthest <= 1.0 + 1e-5, f"it evaluates a traced function at a coordinate of {meter.farthest:g}"
    assert np.abs(outcome.best).max() <= 1.0, "it nominates a point outside the box"


@_check_for(*_ANALYTIC)
def keeps_any_budget(strategy: AbstractStrategy) -> None:
    """Within any budget it spends no more than that, lets BudgetExhausted propagate, and the best point is kept."""
    dim = _at_least(strategy, 3)
    for limit in (1, 2, 3, 7, 20, 50):
        meter = problems.Meter()
        watched = _Watched(_bowl(strategy, dim, meter), Budget(evaluations=limit))
        try:
            strategy.run(watched, np.zeros(dim), 0)
        except BudgetExhausted:
            pass
        else:
            assert not watched.exhaustions, "it swallows BudgetExhausted"
        used = meter.total
        assert used <= limit, f"it makes {used:g} evaluations with a budget of {limit}"
        assert watched.spent >= used - 1e-6, f"it declares {watched.spent:g} evaluations, but makes {used:g}"
        assert watched.exhaustions <= 64, "it goes on evaluating after BudgetExhausted"
        run = run_strategy(strategy, Objective(_bowl(strategy, dim), limit), np.zeros(dim))
        best_evaluated = np.nanmax(np.append(run.trace.values, run.start_value))
        assert run.value >= best_evaluated, "the best point evaluated is lost"


@_check_for(*_ANALYTIC)
def is_honest(strategy: AbstractStrategy) -> None:
    """It nominates a point that is as good as the best one that it evaluated."""
    bowl = _bowl(strategy, _at_least(strategy, 3))
    objective = Objective(bowl, _PLENTY)
    outcome = _outcome(strategy, objective)
    evaluated = objective.trace.points
    value = float(bowl.values(outcome.best[None])[0])
    best = bowl.values(evaluated).max() if len(evaluated) else -np.inf
    assert value >= best - 1e-6, f"it nominates a point of value {value} although it evaluated one of {best}"


@_check_for(*_ANALYTIC)
def is_deterministic(strategy: AbstractStrategy) -> None:
    """The same seed gives the same trace."""
    dim = _at_least(strategy, 3)
    traces = []
    for _ in range(2):
        stairs = problems.linear if strategy.needs is Need.RESIDUALS else problems.staircase
        objective = Objective(problem(stairs, dim), Budget(evaluations=300))
        _outcome(strategy, objective)
        traces.append(objective.trace.points)
    assert np.array_equal(*traces), "two runs with the same seed differ"


@_check_for(*_ANALYTIC)
def lets_exceptions_pass(strategy: AbstractStrategy) -> None:
    """It lets exceptions of the objective propagate, KeyboardInterrupt (Ctrl-C) included."""
    dim = _at_least(strategy, 3)
    for planted in (ZeroDivisionError, KeyboardInterrupt):
        objective = _Failing(_bowl(strategy, dim), planted)
        try:
            strategy.run(objective, np.zeros(dim), 0)
        except (StrategyError, planted):
            continue
        assert objective.calls < 2, f"it swallows the {planted.__name__} that the objective raised"


@_check_for(*_SCORES, Need.IMAGES)
def repairs_a_stereo_rig(strategy: AbstractStrategy) -> None:
    """It recovers part of the score of a small rendered stereo rig that is half a degree off."""
    objective, truth = _stereo_objective()
    run = run_strategy(strategy, objective.with_budget(100), np.zeros(objective.dim), seed=1)
    target = float(objective.problem.values(truth[None])[0])
    gained = (run.value - run.start_value) / (target - run.start_value)
    assert gained >= 0.2, f"it recovers {gained:.2f} of the lost score, not 0.2"


@_check_for(Need.IMAGES)
def repairs_it_the_same_way_twice(strategy: AbstractStrategy) -> None:
    """The same seed gives the same nomination."""
    objective, _ = _stereo_objective()
    first, second = (_outcome(strategy, objective.with_budget(_PLENTY)).best for _ in range(2))
    assert np.array_equal(first, second), "two runs with the same seed differ"


@_check_for(*Need)
def travels(strategy: AbstractStrategy) -> None:
    """It pickles, and the copy is equal: trials run in other processes."""
    assert pickle.loads(pickle.dumps(strategy)) == strategy, "a pickled copy is not equal"


def check_strategy(strategy: AbstractStrategy) -> tuple[CheckResult, ...]:
    """Run the conformance checks that apply to the strategy, without pytest; one result for each check."""
    return STRATEGY_CHECKS.run(strategy)


class StrategyConformance:
    """Inherit from it and set `strategy`; pytest then runs every check that applies as a test:
    `class TestMine(StrategyConformance): strategy = Mine()`.
    """

    strategy: ClassVar[AbstractStrategy]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        STRATEGY_CHECKS.add_tests(cls, cls.strategy)


@lru_cache(maxsize=1)
def _stereo_objective() -> tuple[Objective, Float[np.ndarray, "n"]]:
    """The objective of a small rig that sees a rendered harbour, half a degree off; and the point of the true rig."""
    true = default_rig().resized(_SIZE)
    scene = render("harbour", 3, rig=true)
    offset = count_chart(true, _REACH).extrinsics(_TRUTH) - true.extrinsics
    drifted = true.with_extrinsics(true.extrinsics - offset)
    truth = count_chart(drifted, _REACH).coordinates_of(true)
    return objective(drifted, scene.pairs, matcher=SAD(num_disparities=32, block_size=7), reach=_REACH), truth


class _Watched(Objective):
    """Counts how often it raised BudgetExhausted."""

    exhaustions = 0

    def _raise_if_exhausted(self) -> None:
        try:
            super()._raise_if_exhausted()
        except BudgetExhausted:
            self.exhaustions += 1
            raise


class _Failing(Objective):
    """Answers one call, then raises `planted` at every other."""

    def __init__(self, problem: Problem, planted: type[BaseException]) -> None:
        super().__init__(problem, _PLENTY)
        self.planted = planted
        self.calls = 0

    def _record(self, points: np.ndarray, values: np.ndarray, cost: float) -> None:
        self.calls += 1
        if self.calls > 1:
            raise self.planted("planted by the conformance kit")
        super()._record(points, values, cost)


def _dimensions(strategy: AbstractStrategy) -> tuple[int, ...]:
    return strategy.min_dim, 6 if strategy.max_dim is None else min(6, strategy.max_dim)


def _at_least(strategy: AbstractStrategy, dim: int) -> int:
    return max(strategy.min_dim, dim if strategy.max_dim is None else min(dim, strategy.max_dim))


def _bowl(strategy: AbstractStrategy, dim: int, meter: problems.Meter | None = None) -> Problem:
    return _problem_of(strategy, problems.bowl, dim, meter)


def _problem_of(
    strategy: AbstractStrategy, score: problems.Score, dim: int, meter: problems.Meter | None = None
) -> Problem:
    """The problem of a score, or of the residuals that stand for it, by what the strategy needs."""
    return problem(problems.AS_RESIDUALS[score] if strategy.needs is Need.RESIDUALS else score, dim, meter)


def _assert_climbs(strategy: AbstractStrategy, climb: Problem, share: float) -> None:
    run = run_strategy(strategy, Objective(climb, _PLENTY), np.zeros(climb.dim))
    top = 0.0 if strategy.needs is Need.RESIDUALS else 1.0
    climbed = (run.value - run.start_value) / (top - run.start_value)
    assert climbed >= share, (
        f"in {climb.dim} dimensions it climbs {climbed:.1%} of the way up, and less than {share:.0%}; let it search "
        "longer, or shrink its step more slowly"
    )


def _outcome(strategy: AbstractStrategy, objective: Objective, start: np.ndarray | None = None) -> Outcome:
    start = np.zeros(objective.dim) if start is None else start
    try:
        return strategy.run(objective, start, 0)
    except BudgetExhausted:
        trace = objective.trace
        if not len(trace.values):
            return Outcome(start, Status.BUDGET)
        best = trace.points[-1] if np.isnan(trace.values).all() else trace.points[np.nanargmax(trace.values)]
        return Outcome(best, Status.BUDGET)
