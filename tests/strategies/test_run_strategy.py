"""What a strategy nominates is judged by the objective's own values."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from stereorecal import StrategyError
from stereorecal.strategies import (
    AbstractStrategy,
    Budget,
    Need,
    NeedNotMet,
    Objective,
    Outcome,
    Problem,
    Status,
    run_strategy,
)


@dataclass(frozen=True)
class Scripted(AbstractStrategy):
    """Asks for `asked`, then nominates."""

    asked: tuple = ()
    nominated: tuple = (0.0,)
    status: Status = Status.CONVERGED
    message: str = ""

    def run(self, objective, start, seed):
        if self.asked:
            objective.batch(np.array(self.asked, float)[:, None])
        return Outcome(np.array(self.nominated), self.status, self.message)


def problem(function: Callable, budget: Budget | None = None) -> Objective:
    return Objective(Problem(1, lambda points: np.array([function(float(x)) for x in points[:, 0]]), cost=0.25), budget)


def hill(x: float) -> float:
    return 1.0 - (x - 0.5) ** 2


def judged(strategy, function=hill, start=0.0, budget=None):
    return run_strategy(strategy, problem(function, budget), np.array([start]))


def test_an_honest_nomination_wins():
    run = judged(Scripted((0.2, 0.4), (0.4,)))
    assert run.best == [0.4]
    assert run.value == hill(0.4)
    assert run.start_value == hill(0.0)
    assert run.status is Status.CONVERGED


def test_the_judge_looks_at_no_point_twice():
    """The start is nominated, and was never asked."""
    looked = []
    run = judged(Scripted((), (0.0,)), lambda x: looked.append(x) or hill(x))
    assert looked == [0.0]
    assert run.value == run.start_value == hill(0.0)


def test_a_liar_is_not_believed():
    run = judged(Scripted((0.2, 0.4), (-0.9,)))
    assert run.best == [0.4]
    assert run.value == hill(0.4)


def test_a_nomination_that_was_never_evaluated_is_evaluated_for_free():
    run = judged(Scripted((0.2,), (0.5,)), budget=Budget(evaluations=0.25))
    assert run.best == [0.5]
    assert run.value == 1.0
    assert run.trace.total_cost == 0.25


@pytest.mark.parametrize(
    ("asked", "nominated", "judged_points"),
    [
        ((0.0, 0.4), 0.4, 0),
        ((0.2, 0.4), 0.4, 1),  # the start
        ((0.2, 0.4), 0.7, 2),  # the start and the nomination
        ((), 0.0, 1),  # both are one point
        ((), 0.1, 2),
    ],
)
def test_what_judging_costs_is_counted_apart(asked, nominated, judged_points):
    run = judged(Scripted(asked, (nominated,)))
    assert run.judging_cost == 0.25 * judged_points
    assert run.trace.total_cost == 0.25 * len(asked)


def test_judging_a_charged_point_is_counted():
    @dataclass(frozen=True)
    class Inside(AbstractStrategy):
        def run(self, objective, start, seed):
            objective.charge(0.5, best=np.array([0.5]))
            return Outcome(np.array([0.5]), Status.CONVERGED)

    run = judged(Inside())
    assert run.judging_cost == 0.5  # the start and the charged point, which is the nomination


def test_every_run_gets_the_whole_budget_whatever_was_spent_before():
    objective = problem(hill, Budget(evaluations=0.5))
    objective.batch(np.array([[0.1], [0.2]]))
    for _ in range(2):
        run = run_strategy(Scripted((0.3, 0.4), (0.4,)), objective, np.zeros(1))
        assert run.status is Status.CONVERGED
        assert run.trace.total_cost == 0.5
    assert objective.spent == 0.5


def test_infinity_does_not_hide_the_best_finite_value():
    run = judged(Scripted((0.2, 0.8, 0.4), (0.8,)), lambda x: float("inf") if x > 0.7 else hill(x))
    assert run.best == [0.4]


def test_the_start_wins_when_nothing_is_better():
    run = judged(Scripted((0.1, 0.9), (0.9,)), start=0.5)
    assert run.best == [0.5]
    assert run.value == run.start_value == 1.0


def test_the_start_wins_a_tie():
    run = judged(Scripted((0.7,), (0.7,)), lambda x: float(abs(x) < 0.9), start=0.5)
    assert run.best == [0.5]


def test_nan_never_wins():
    run = judged(Scripted((0.2, 0.8), (0.8,)), lambda x: float("nan") if x > 0.7 else hill(x))
    assert run.best == [0.2]
    assert run.value == hill(0.2)


def test_nan_everywhere_keeps_the_start():
    run = judged(Scripted((0.2, 0.8), (0.8,)), lambda x: float("nan"), start=0.3)
    assert run.best == [0.3]


def test_no_signal():
    run = judged(Scripted((0.2, 0.8), (0.8,)), lambda x: 7.0)
    assert run.status is Status.NO_SIGNAL
    assert run.best == [0.0]


def test_one_point_tells_nothing_about_the_signal():
    """A budget of one evaluation, spent on the start."""
    run = judged(Scripted((0.0,), (0.0,)), budget=Budget(evaluations=0.25))
    assert run.status is Status.CONVERGED


def test_a_charged_point_can_win():
    @dataclass(frozen=True)
    class Inside(AbstractStrategy):
        def run(self, objective, start, seed):
            objective.charge(3.0, best=np.array([0.5]))
            return Outcome(start, Status.CONVERGED)

    run = judged(Inside())
    assert run.best == [0.5]
    assert run.trace.total_cost == 3.0


@pytest.mark.parametrize("bad", [(1.5,), (float("nan"),), (0.0, 0.0), ()])
def test_a_nomination_that_is_no_point_is_the_strategys_fault(bad):
    with pytest.raises(StrategyError, match=r"strategy Scripted \(.*\) nominated no point of the unit box"):
        judged(Scripted((), bad))


def test_message():
    assert judged(Scripted((0.2,), (0.2,))).message == Status.CONVERGED.value
    assert judged(Scripted((0.2,), (0.2,), message="it stood still")).message == "it stood still"


@dataclass(frozen=True)
class Crashing(AbstractStrategy):
    def run(self, objective, start, seed):
        raise KeyError("a bug")


def test_a_crash_names_the_module_of_a_local_strategy():
    with pytest.raises(
        StrategyError, match=rf"Crashing \({Crashing.__module__}\) crashed: KeyError\('a bug'\)"
    ) as caught:
        judged(Crashing())
    assert isinstance(caught.value.__cause__, KeyError)


def test_a_crash_names_distribution_and_version_of_an_installed_strategy(install):
    install("stereorecal.strategies", {"clumsy": f"{Crashing.__module__}:Crashing"})
    with pytest.raises(StrategyError, match=r"clumsy \(plug-in 1\.2\) crashed: KeyError\('a bug'\)"):
        judged(Crashing())


def test_ctrl_c_is_no_crash():
    @dataclass(frozen=True)
    class Interrupted(AbstractStrategy):
        def run(self, objective, start, seed):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        judged(Interrupted())


@pytest.mark.parametrize(
    ("need", "words"),
    [(Need.SMOOTH, "differentiable score"), (Need.RESIDUALS, "least-squares residuals"), (Need.IMAGES, "the images")],
)
def test_needs_are_checked_before_anything_runs(need, words):
    class Needy(Crashing):
        needs = need

    with pytest.raises(NeedNotMet, match=f"strategy Needy cannot serve here: it needs .*{words}"):
        judged(Needy())


def test_greatest_number_of_parameters():
    class Narrow(Crashing):
        max_dim = 1

    with pytest.raises(NeedNotMet, match="Narrow takes at most 1 free parameters, not 2"):
        run_strategy(Narrow(), Objective(Problem(2, lambda points: points.sum(axis=1))), np.zeros(2))


def test_least_number_of_parameters():
    class Wide(Crashing):
        min_dim = 2

    with pytest.raises(NeedNotMet, match="Wide needs at least 2 free parameters, not 1"):
        judged(Wide())


def test_the_strategy_cannot_move_the_start():
    @dataclass(frozen=True)
    class Vandal(AbstractStrategy):
        def run(self, objective, start, seed):
            start[:] = 0.9
            return Outcome(start, Status.CONVERGED)

    start = np.array([0.5])
    run = run_strategy(Vandal(), problem(hill), start)
    assert start == [0.5]
    assert run.best == [0.5]


@dataclass(frozen=True)
class Decorated(AbstractStrategy):
    """The contract leaves room for what a caller need not give."""

    def run(self, objective, start, seed, *extra, tolerance=0.1, **more):
        return Outcome(start, Status.CONVERGED)


def test_further_arguments_with_defaults_are_accepted():
    assert judged(Decorated()).status is Status.CONVERGED


class ClimbsInside(AbstractStrategy):
    """Inside JAX, and cut short."""

    def run(self, objective, start, seed):
        for step in (0.1, 0.3, 0.2):
            objective.charge(1.0, best=np.array([step]))
        return Outcome(start, Status.BUDGET)


def test_of_charged_points_the_last_one_is_judged():
    objective = Objective(Problem(1, lambda points: -np.abs(points[:, 0] - 0.3)))
    assert run_strategy(ClimbsInside(), objective, np.zeros(1)).best == 0.2
