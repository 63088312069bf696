"""A search on the host: seeds, ends, exceptions, scores without a value."""

import contextlib
import gc
import threading
import weakref

import nlopt
import numpy as np
import pytest
import stereorecal_nlopt
from hypothesis import given, settings, strategies as st
from stereorecal_nlopt import Bobyqa, Cobyla, Crs2, Direct, Isres, Mlsl, NelderMead, NewuoaBound, Sbplx
from stereorecal_nlopt._search import Memory, search

from stereorecal.strategies import Budget, BudgetExhausted, Need, Objective, Problem, Status, run_strategy

HOST = [c() for c in vars(stereorecal_nlopt).values() if isinstance(c, type) and c.needs is Need.HOST]
RANDOM = {"Praxis", "DirectLRand", "Crs2", "Isres", "Esch", "Mlsl"}
GLOBAL = [strategy for strategy in HOST if hasattr(strategy, "evaluations")]
SUMMIT = np.array([0.3, -0.4, 0.1])


def each(strategies):
    return pytest.mark.parametrize("strategy", strategies, ids=lambda s: type(s).__name__)


def steps(points):
    """A bowl in steps, as counts are."""
    return np.floor(64 * (2.0 - ((points - SUMMIT) ** 2).sum(-1)))


def searched(strategy, values=steps, budget=None, seed=0, dim=3):
    """The outcome (None if the budget ended it) and the meter."""
    objective = Objective(Problem(dim, values), budget)
    try:
        return strategy.run(objective, np.zeros(dim), seed), objective
    except BudgetExhausted:
        return None, objective


@each(HOST)
def test_the_seed_decides_and_nothing_else(strategy):
    traces = [searched(strategy, budget=Budget(100), seed=seed)[1].trace.points for seed in (7, 2**40 + 7, 8, 7)]
    assert np.array_equal(traces[0], traces[3])
    assert np.array_equal(traces[0], traces[2]) == (type(strategy).__name__ not in RANDOM)


def test_searches_in_other_threads_do_not_disturb():
    alone = [searched(Crs2(), budget=Budget(100), seed=seed)[1].trace.points for seed in (1, 2)]
    together, turn = {}, threading.Barrier(2)

    def values(points):
        turn.wait(timeout=60)  # strictly in turns
        return steps(points)

    def work(seed):
        together[seed] = searched(Crs2(), values, Budget(100), seed)[1].trace.points

    threads = [threading.Thread(target=work, args=(seed,)) for seed in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(together[1], alone[0])
    assert np.array_equal(together[2], alone[1])


@each([Bobyqa(), Cobyla(), NewuoaBound(), NelderMead(), Sbplx()])
@pytest.mark.parametrize("step", [1 / 16, 0.5])
def test_the_first_step_is_the_one_asked_for(strategy, step):
    points = searched(type(strategy)(step=step))[1].trace.points
    np.testing.assert_array_equal(points[0], 0.0)
    np.testing.assert_allclose(np.abs(points[1]).max(), step)


@each(HOST)
def test_it_begins_at_the_start_or_in_the_middle(strategy):
    """The start is a known calibration: what is found near it is worth most."""
    first = searched(strategy, budget=Budget(1))[1].trace.points[0]
    if type(strategy).__name__ != "Ags":  # its curve begins elsewhere
        np.testing.assert_array_equal(first, 0.0)


def smooth(points):
    return 1.0 - ((points - SUMMIT) ** 2).sum(-1)


@pytest.mark.parametrize(
    ("strategy", "message"),
    [
        (Bobyqa(), "the steps are shorter than xtol"),
        (NelderMead(ftol=0.1), "the score changes by less than ftol"),
        (Crs2(), "the steps are shorter than xtol"),
        (Direct(evaluations=50), "the option `evaluations` ends a search whose budget has no limit"),
    ],
)
def test_how_it_ended(strategy, message):
    outcome, _ = searched(strategy, smooth)
    assert (outcome.status, outcome.message) == (Status.CONVERGED, message)


class Ending(nlopt.opt):
    """NLopt with an end of our choice."""

    def __init__(self, result, error=None):
        super().__init__(nlopt.LN_BOBYQA, 3)
        self.__dict__.update(result=result, error=error)

    def optimize(self, start):
        memory.keep(start, 1.0)
        if self.error:
            raise self.error

    def last_optimize_result(self):
        return self.result


memory = Memory(np.zeros(3))


@pytest.mark.parametrize(
    ("result", "error", "status", "message"),
    [
        (nlopt.ROUNDOFF_LIMITED, nlopt.RoundoffLimited(), Status.CONVERGED, "rounding"),
        (nlopt.STOPVAL_REACHED, None, Status.CONVERGED, "upper limit"),
        (nlopt.SUCCESS, None, Status.CONVERGED, "its own stopping rule"),
        (nlopt.FAILURE, nlopt.runtime_error("x"), Status.STALLED, "NLopt gave up: no reason given"),
        (nlopt.OUT_OF_MEMORY, None, Status.STALLED, "NLopt gave up: no reason given"),
    ],
)
def test_ends_that_are_hard_to_bring_about(result, error, status, message):
    outcome = search(Ending(result, error), lambda z, gradient: 1.0, memory, 0)
    assert outcome.status is status
    assert message in outcome.message


@each(GLOBAL)
def test_without_a_budget_it_ends(strategy):
    """On a flat score nothing else can end it; CRS2 finishes what it has begun."""
    outcome, objective = searched(type(strategy)(evaluations=100), lambda points: np.ones(len(points)))
    assert outcome.status is Status.CONVERGED
    assert 100 <= len(objective.trace.values) <= 104


@pytest.mark.slow(after=6)
@each(GLOBAL)
@pytest.mark.parametrize("budget", [Budget(evaluations=300), Budget(seconds=0.2)])
def test_a_budget_takes_the_place_of_its_own_limit(strategy, budget):
    outcome, objective = searched(type(strategy)(evaluations=10), lambda points: np.ones(len(points)), budget)
    assert outcome is None
    assert len(objective.trace.values) > 10


@settings(deadline=None)
@given(strategy=st.sampled_from(HOST), limit=st.integers(1, 150), seed=st.integers(0, 3))
def test_stopped_anywhere_it_loses_nothing(strategy, limit, seed):
    asked = []

    def values(points):
        asked.extend(points)
        return steps(points)

    run = run_strategy(strategy, Objective(Problem(3, values), limit), np.zeros(3), seed)
    assert len(run.trace.values) <= limit
    assert run.status is not Status.BUDGET or len(run.trace.values) == limit
    assert run.value == max(run.trace.values.max(), run.start_value)
    assert len(asked) <= len(run.trace.values) + 2  # the judge's two


@pytest.mark.slow(after=28)
@each(HOST)
@pytest.mark.parametrize("planted", [KeyboardInterrupt, ZeroDivisionError])
@pytest.mark.parametrize("after", [0, 1, 2, 30])
def test_an_exception_passes_as_it_is_and_nothing_is_asked_after_it(strategy, planted, after):
    asked = 0

    def values(points):
        nonlocal asked
        asked += 1
        if asked > after:
            raise planted("planted")
        return steps(points)

    if after == 30 and len(searched(strategy)[1].trace.values) <= 30:
        return
    with pytest.raises(planted, match="planted"):
        searched(strategy, values)
    assert asked == after + 1


@each(HOST)
@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf])
def test_a_score_without_value_is_never_nominated(strategy, nothing):
    outcome, objective = searched(strategy, lambda p: np.where(p[:, 0] > 0.1, nothing, smooth(p)), Budget(300))
    points, values = objective.trace.points, objective.trace.values
    assert outcome is None or outcome.best[0] <= 0.1
    assert np.max(values, initial=-np.inf, where=np.isfinite(values)) > 0.85
    assert points[np.argmax(np.where(np.isfinite(values), values, -np.inf)), 0] <= 0.1


@each(HOST)
def test_a_start_without_value_is_left(strategy):
    outcome, objective = searched(
        strategy, lambda p: np.where((p == 0).all(-1), np.nan, -np.abs(p).sum(-1)), Budget(300)
    )
    assert np.isfinite(objective.trace.values).any()
    assert outcome is None or np.any(outcome.best != 0)


@each(HOST)
def test_no_value_anywhere(strategy):
    outcome, _ = searched(strategy, lambda points: np.full(len(points), np.nan), Budget(300))
    if outcome is not None:
        assert outcome.status is Status.STALLED
        assert outcome.message == "the score has no value at any point that was tried"
        np.testing.assert_array_equal(outcome.best, 0.0)


POINT = st.lists(st.floats(-1, 1), min_size=2, max_size=2).map(np.array)


@settings(deadline=None)
@given(seen=st.lists(st.tuples(POINT, st.floats(-1e6, 1e6)), min_size=1), z=POINT)
def test_the_stand_in_is_worse_than_all_and_leads_back(seen, z):
    kept = Memory(np.zeros(2))
    for point, value in seen:
        kept.keep(point, value)
    value, gradient = kept.stand_in(z)
    assert kept.highest == max(value for _, value in seen)
    assert value < min(value for _, value in seen)
    assert np.isfinite(gradient).all()
    back = kept.best - z
    assert gradient @ back > 0 or np.linalg.norm(back) < 1e-6


@pytest.mark.slow(after=1)
@each([Bobyqa(), Isres(), Mlsl()])
def test_nothing_is_left_behind(strategy):
    """NLopt's objects are out of sight of the garbage collector: a cycle through them would stay for ever."""
    objective = Objective(Problem(3, steps), Budget(50))
    left = weakref.ref(objective)
    with contextlib.suppress(BudgetExhausted):
        strategy.run(objective, np.zeros(3), 0)
    del objective
    gc.collect()
    assert left() is None
