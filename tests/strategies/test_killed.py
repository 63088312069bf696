"""A strategy that is killed by any budget loses nothing: the best point seen is returned."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.strategies import AbstractStrategy, Objective, Outcome, Problem, Status, run_strategy, strategy


@dataclass(frozen=True)
class RandomSearch(AbstractStrategy):
    """Uniform points in batches of any size, for ever; never says what was best."""

    batch: int = 3

    def run(self, objective, start, seed):
        random = np.random.default_rng(seed)
        for _ in range(10_000):
            objective.batch(random.uniform(-1, 1, (self.batch, objective.dim)))
        return Outcome(start, Status.STALLED)


def rugged(points):
    return np.sin(7 * points).sum(axis=1) - (points**2).sum(axis=1)


@pytest.mark.parametrize("dim", [1, 3, 5])
@settings(max_examples=max(4, settings.default.max_examples // 5))
@given(
    limit=st.integers(1, 80), cost=st.sampled_from([1.0, 0.25, 0.09]), batch=st.integers(1, 9), seed=st.integers(0, 99)
)
def test_best_seen_is_returned(dim, limit, cost, batch, seed):
    start = np.full(dim, 0.1)
    forever = {"min_step": 1e-9}
    names = ("compass", "gradient-descent", "secant")
    for killed in (RandomSearch(batch), *(strategy(name, **forever) for name in names)):
        run = run_strategy(killed, Objective(Problem(dim, rugged, cost), limit), start, seed)
        assert run.trace.total_cost <= limit + 1e-9
        assert run.value == max(run.trace.values.max(initial=-np.inf), rugged(start[None])[0])
        assert run.value == rugged(run.best[None])[0]
        assert run.start_value == rugged(start[None])[0]


def test_the_status_says_that_it_was_killed():
    run = run_strategy(RandomSearch(), Objective(Problem(2, rugged), 20), np.zeros(2))
    assert run.status is Status.BUDGET
    assert run.message == Status.BUDGET.value
