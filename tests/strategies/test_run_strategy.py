"""What a strategy nominates is judged by the objective's own values."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from moody import Crashing

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


NAN, INFINITE = float("nan"), float("inf")
NOMINATIONS = {  # what was asked, what is nominated, the start, the score; what is the best
    "honest": ((0.2, 0.4), 0.4, 0.0, hill, 0.4),
    "a lie": ((0.2, 0.4), -0.9, 0.0, hill, 0.4),
    "never evaluated": ((0.2,), 0.5, 0.0, hill, 0.5),
    "infinite": ((0.2, 0.8, 0.4), 0.8, 0.0, lambda x: INFINITE if x > 0.7 else hill(x), 0.4),
    "worse than the start": ((0.1, 0.9), 0.9, 0.5, hill, 0.5),
    "as good as the start": ((0.7,), 0.7, 0.5, lambda x: float(abs(x) < 0.9), 0.5),
    "no number": ((0.2, 0.8), 0.8, 0.0, lambda x: NAN if x > 0.7 else hill(x), 0.2),
    "no number anywhere": ((0.2, 0.8), 0.8, 0.3, lambda x: NAN, 0.3),
}


@pytest.mark.parametrize(("asked", "nominated", "start", "score", "best"), NOMINATIONS.values(), ids=NOMINATIONS)
def test_the_best_that_was_seen_is_returned(asked, nominated, start, score, best):
    """And judging is free: the strategy has spent all of its budget."""
    run = judged(Scripted(asked, (nominated,)), score, start, Budget(evaluations=0.25 * len(asked)))
    assert run.best == [best]
    np.testing.assert_array_equal([run.value, run.start_value], [score(best), score(start)])
    assert run.status is Status.CONVERGED
    assert run.trace.total_cost == 0.25 * len(asked)


def test_the_judge_looks_at_no_point_twice():
    """The start is nominated, and was never asked."""
    looked = []
    run = judged(Scripted((), (0.0,)), lambda x: looked.append(x) or hill(x))
    assert looked == [0.0]
    assert run.value == run.start_value == hill(0.0)


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


@dataclass(frozen=True)
class Inside(AbstractStrategy):
    """Climbs inside JAX, which tells its best points alone."""

    told: tuple = (0.5,)
    nominated: float = 0.0

    def run(self, objective, start, seed):
        for point in self.told:
            objective.charge(0.5, best=np.array([point]))
        return Outcome(np.array([self.nominated]), Status.CONVERGED)


@pytest.mark.parametrize(
    ("told", "nominated", "best"), [((0.5,), 0.5, 0.5), ((0.5,), 0.0, 0.5), ((0.1, 0.4, 0.2), 0.0, 0.2)]
)
def test_of_charged_points_the_last_one_is_judged(told, nominated, best):
    """Whether it is nominated or not."""
    run = judged(Inside(told, nominated))
    assert run.best == [best]
    assert run.judging_cost == 0.5  # of that and of the start
    assert run.trace.total_cost == 0.5 * len(told)


def test_no_signal():
    """One point alone cannot show that there is none: a budget of one evaluation, spent on the start."""
    run = judged(Scripted((0.2, 0.8), (0.8,)), lambda x: 7.0)
    assert (run.status, run.best) == (Status.NO_SIGNAL, [0.0])
    assert judged(Scripted((0.0,), (0.0,)), budget=Budget(evaluations=0.25)).status is Status.CONVERGED


@pytest.mark.parametrize("bad", [(1.5,), (float("nan"),), (0.0, 0.0), ()])
def test_a_nomination_that_is_no_point_is_the_strategys_fault(bad):
    with pytest.raises(StrategyError, match=r"strategy Scripted \(.*\) nominated no point of the unit box"):
        judged(Scripted((), bad))


def test_a_crash_names_the_module_or_distribution_and_version_of_a_strategy(install):
    crash = r"crashed: KeyError\('a bug'\)"
    with pytest.raises(StrategyError, match=rf"Crashing \({Crashing.__module__}\) {crash}") as caught:
        judged(Crashing())
    assert isinstance(caught.value.__cause__, KeyError)
    install("stereorecal.strategies", {"clumsy": f"{Crashing.__module__}:Crashing"})
    with pytest.raises(StrategyError, match=rf"clumsy \(plug-in 1\.2\) {crash}"):
        judged(Crashing())


def test_ctrl_c_is_no_crash():
    @dataclass(frozen=True)
    class Interrupted(AbstractStrategy):
        def run(self, objective, start, seed):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        judged(Interrupted())


@pytest.mark.parametrize(
    ("asks", "dim", "words"),
    [
        ({"needs": Need.SMOOTH}, 1, "cannot serve here: it needs .*differentiable score"),
        ({"needs": Need.RESIDUALS}, 1, "cannot serve here: it needs .*least-squares residuals"),
        ({"needs": Need.IMAGES}, 1, "cannot serve here: it needs .*the images"),
        ({"max_dim": 1}, 2, "takes at most 1 free parameters, not 2"),
        ({"min_dim": 2}, 1, "needs at least 2 free parameters, not 1"),
    ],
)
def test_needs_are_checked_before_anything_runs(asks, dim, words):
    needy, objective = type("Needy", (Crashing,), asks)(), Objective(Problem(dim, lambda x: x.sum(axis=1)))
    with pytest.raises(NeedNotMet, match=f"strategy Needy {words}"):
        run_strategy(needy, objective, np.zeros(dim))


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
