"""An objective that counts what it is asked, inside of JAX too: budgets are kept exactly, all is recorded."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.strategies import Budget, BudgetExhausted, Objective, Problem


@dataclass
class Counter:
    """A bowl with its top at 0.3 in both coordinates; knows how many points reached it."""

    evaluated: int = 0

    def values(self, points):
        self.evaluated += len(points)
        return 1.0 - np.sum((points - 0.3) ** 2, axis=1)

    def objective(self, cost: float = 1.0, **budget) -> Objective:
        return Objective(Problem(2, self.values, cost), Budget(**budget) if budget else None)


@pytest.fixture
def counter() -> Counter:
    return Counter()


WAYS = {
    "value": lambda objective, point: objective.value(point),
    "batch": lambda objective, point: objective.batch(np.stack([np.zeros(2), point])),
    "charge": lambda objective, point: objective.charge(0.1, best=point),
}


# --- budgets ------------------------------------------------------------------------------------------------


@given(
    limit=st.integers(1, 40),
    cost=st.sampled_from([1.0, 0.25, 0.09, 0.01, 3.0]),
    sizes=st.lists(st.integers(0, 12), max_size=15),
)
def test_spent_exactly(limit, cost, sizes):
    """A batch that does not fit is evaluated as far as it fits, from its first point on."""
    evaluated: list[int] = []
    objective = Objective(Problem(1, lambda x: evaluated.append(len(x)) or x[:, 0], cost), Budget(evaluations=limit))
    most = int((limit + 1e-9) // cost)
    points, raised = np.random.default_rng(limit).uniform(-1, 1, (sum(sizes), 1)), False
    asked = 0
    for size in sizes:
        fits = asked + size <= most
        batch = points[asked : asked + size]
        asked += size
        if fits:
            assert len(objective.batch(batch)) == size
            assert objective.remaining == pytest.approx(limit - objective.spent)
        else:
            raised = True
            with pytest.raises(BudgetExhausted):
                objective.batch(batch)
            break
    assert sum(evaluated) == len(objective.trace.values) == min(asked, most)
    np.testing.assert_array_equal(objective.trace.points, points[: min(asked, most)])
    assert objective.spent == pytest.approx(sum(evaluated) * cost)
    assert objective.spent <= limit + 1e-9
    assert not raised or objective.remaining == 0


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("ended", ["by a batch", "by a charge", "by a step that does not fit", "by a deadline"])
def test_once_exhausted_it_always_raises_and_evaluates_nothing(counter, ended, way):
    objective = counter.objective(**({"seconds": 1e-12} if ended == "by a deadline" else {"evaluations": 2}))
    endings = {
        "by a batch": lambda: objective.batch(np.zeros((3, 2))),
        "by a charge": lambda: objective.charge(2.0, best=np.array([0.3, 0.3])),
        "by a step that does not fit": lambda: objective.reserve(3.0),
        "by a deadline": lambda: objective.value(np.zeros(2)),
    }
    with pytest.raises(BudgetExhausted):
        endings[ended]()
    evaluated, spent = counter.evaluated, objective.spent
    assert (evaluated, spent) == {"by a batch": (2, 2), "by a charge": (0, 2)}.get(ended, (0, 0))
    for _ in range(2):
        with pytest.raises(BudgetExhausted):
            WAYS[way](objective, np.zeros(2))
        with pytest.raises(BudgetExhausted):
            objective.batch(np.zeros((0, 2)))
    assert (counter.evaluated, objective.remaining) == (evaluated, 0)


def test_a_step_that_fits_may_begin(counter):
    objective = counter.objective(evaluations=4)
    objective.reserve(0.0)
    objective.reserve(4.0)
    assert objective.spent == 0
    assert counter.objective(cost=0.25).gradient_cost == 0.75  # one evaluation more than there are coordinates


# --- the unit box -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("bad", [[1.001, 0.0], [0.0, -1.5], [np.nan, 0.0], [0.0, np.inf]])
def test_points_outside_are_refused_before_anything_is_evaluated(counter, way, bad):
    objective = counter.objective()
    with pytest.raises(ValueError, match="outside the unit box"):
        WAYS[way](objective, np.array(bad))
    assert (counter.evaluated, objective.spent, len(objective.trace.values)) == (0, 0, 0)


@pytest.mark.parametrize("shape", [(1, 3), (2, 1), (0, 3)])
def test_wrong_number_of_coordinates(counter, shape):
    with pytest.raises(ValueError, match=r"takes \(k, 2\)"):
        counter.objective().batch(np.zeros(shape))
    with pytest.raises(ValueError, match="shape"):
        counter.objective().charge(1.0, best=np.zeros(1))


# --- the trace ----------------------------------------------------------------------------------------------


def test_the_trace_holds_every_evaluation_and_charge(counter):
    objective = counter.objective(cost=0.25)
    assert objective.trace.points.shape == (0, 2)
    assert objective.trace.best_within(100) is None
    points = np.array([[0.0, 0.0], [0.3, 0.3], [0.5, -0.5], [0.1, 0.2]])
    first = objective.value(points[0])
    given = points[1:3].copy()
    rest = objective.batch(given)
    given[:] = 0.9  # what is recorded is what was asked, not what the array holds later
    objective.charge(2.5, best=points[3])
    trace = objective.trace
    np.testing.assert_array_equal(trace.points, points)
    np.testing.assert_array_equal(trace.values, [first, *rest, np.nan])
    np.testing.assert_array_equal(trace.cost, [0.25, 0.5, 0.75, 3.25])
    np.testing.assert_array_equal(trace.evaluations[:3], [1, 2, 3])
    assert (np.diff(trace.seconds, prepend=0.0) >= 0).all()
    assert trace.total_cost == objective.spent == 3.25
    assert counter.evaluated == 3


@given(values=st.lists(st.one_of(st.floats(-10, 10), st.just(float("nan"))), min_size=1, max_size=12))
def test_best_within(values):
    queue = np.array(values)
    objective = Objective(Problem(1, lambda points: queue[: len(points)], 0.1))
    objective.batch(np.zeros((len(values), 1)))
    for number in range(len(values) + 1):
        seen = queue[:number][~np.isnan(queue[:number])]
        expected = seen.max() if seen.size else None
        assert objective.trace.best_within(0.1 * number) == expected
