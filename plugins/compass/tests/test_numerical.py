"""Gradient descent and the secant method on differences: they conform, and climb as they say."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_compass.numerical import AbstractAscent, GradientDescent, Secant
from watched import Watched

from stereorecal.strategies import Status, strategy
from stereorecal.testing import StrategyConformance

BOTH = pytest.mark.parametrize("cls", [GradientDescent, Secant])


class TestGradientDescent(StrategyConformance):
    strategy = GradientDescent()


class TestSecant(StrategyConformance):
    strategy = Secant()


def bowl(*summit, steep=1.0):
    return lambda p: -np.sum(steep * (p - summit) ** 2)


def test_their_names():
    assert strategy("gradient-descent") == GradientDescent()
    assert strategy("secant") == Secant()


@BOTH
@pytest.mark.parametrize("options", [(0.0,), (-0.1,), (1.1,), (np.nan,)])
def test_differences_that_make_no_sense(cls, options):
    with pytest.raises(ValueError, match="need 0 < difference <= 1"):
        cls(*options)


@BOTH
@pytest.mark.parametrize("steps", [(0.1, 0.2), (0.1, 0.0), (3.0, 0.1), (np.nan, 0.1), (0.1, np.nan)])
def test_steps_that_make_no_sense(cls, steps):
    with pytest.raises(ValueError, match="need 0 < min_step <= step <= 2"):
        cls(0.1, *steps)


@BOTH
def test_one_iteration_by_hand(cls):
    """f = 3x + 4y: all differences at once, then steps 1/4, 1/8, 1/16 along (3, 4)/5; the first is the best."""
    watched = Watched(lambda p: 3 * p[0] + 4 * p[1])
    watched.run(cls(difference=0.1, step=0.25, min_step=1 / 16))
    start, stencil, line, second = watched.batches[:4]
    np.testing.assert_allclose(start, [[0, 0]])
    np.testing.assert_allclose(stencil, 0.1 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]), atol=1e-15)
    np.testing.assert_allclose(line, np.outer([1 / 4, 1 / 8, 1 / 16], [0.6, 0.8]))
    np.testing.assert_allclose(second.mean(axis=0), [0.15, 0.2])


@BOTH
@pytest.mark.parametrize("dim", [1, 3, 5])
def test_an_iteration_is_two_batches(cls, dim):
    watched = Watched(bowl(*np.full(dim, 0.3)), dim)
    watched.run(cls())
    sizes = [len(batch) for batch in watched.batches[1:]]
    assert sizes[0] == 2 * dim
    assert sizes.count(2 * dim) < 20
    assert all(size == 2 * dim or size <= 5 for size in sizes)  # steps 1/8 ... 1/128


@BOTH
@pytest.mark.parametrize("scale", [2.0**-30, 2.0**30])
def test_the_scale_of_the_score_does_not_matter(cls, scale):
    plain, scaled = (Watched(lambda p, k=k: k * bowl(0.4, -0.3, steep=np.array([1, 5]))(p)) for k in (1.0, scale))
    assert np.array_equal(plain.run(cls()).best, scaled.run(cls()).best)
    assert np.array_equal(np.concatenate(plain.batches), np.concatenate(scaled.batches))


@BOTH
def test_it_reaches_the_summit_of_a_bowl(cls):
    outcome = Watched(bowl(0.4, -0.3, 0.2), 3).run(cls())
    assert outcome.status is Status.CONVERGED
    np.testing.assert_allclose(outcome.best, [0.4, -0.3, 0.2], atol=1 / 128)


def test_the_secant_method_steps_onto_the_summit():
    """In one dimension two differences say where it is: 0 -> 1/8 -> 2/8 (longest steps) -> the summit itself."""
    watched = Watched(bowl(0.3), 1)
    assert watched.run(Secant()).best[0] == pytest.approx(0.3, abs=1e-12)
    assert [float(batch.mean()) for batch in watched.batches if len(batch) == 2] == pytest.approx([0, 0.125, 0.25, 0.3])


def test_the_secant_method_is_better_on_a_narrow_ridge():
    turn = np.array([[2, 1, 0], [-1, 2, 0], [0, 1, 1]])

    def evaluations_and_value(cls):
        watched = Watched(lambda p: bowl(0, 0, 0, steep=np.array([1, 20, 5]))(turn @ (p - [0.5, 0.3, -0.4])), 3)
        best = watched.run(cls(difference=1e-3, min_step=1e-4)).best
        return sum(map(len, watched.batches)), watched.objective.value(best)

    (few, high), (many, low) = evaluations_and_value(Secant), evaluations_and_value(GradientDescent)
    assert few < many / 2
    assert high > low


def test_what_is_learned():
    """The secant equation, a symmetric positive matrix, and nothing where the gradient rises along the move."""
    move, fall, other = np.array([0.1, 0.2, 0.0]), np.array([0.3, 0.1, 0.2]), np.array([0.1, 0.0, 0.4])
    first = Secant().learned(None, other, other)
    second = Secant().learned(first, move, fall)
    assert first is not None
    assert second is not None
    np.testing.assert_allclose(first, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(second @ fall, move, atol=1e-12)
    np.testing.assert_allclose(second, second.T, atol=1e-12)
    assert np.linalg.eigvalsh(second).min() > 0
    assert Secant().learned(second, move, -fall) is second
    assert Secant().learned(None, move, np.zeros(3)) is None
    assert GradientDescent().learned(None, move, fall) is None


def test_a_misleading_estimate_is_forgotten():
    @dataclass(frozen=True)
    class Sideways(AbstractAscent):
        def learned(self, inverse, move, fall):
            return np.array([[0.0, -1.0], [1.0, 0.0]])

    outcome = Watched(bowl(0.4, 0.0)).run(Sideways())
    np.testing.assert_allclose(outcome.best, [0.4, 0.0], atol=1 / 64)


@BOTH
def test_at_the_border_differences_are_one_sided(cls):
    """f = -x - y from (1, 0): the way is (-1, -1), although the difference along x has half the length."""
    watched = Watched(lambda p: -p.sum())
    watched.run(cls(), [1.0, 0.0])
    np.testing.assert_allclose(watched.batches[2][0], np.array([1.0, 0.0]) - 0.125 / np.sqrt(2))


@BOTH
def test_along_the_border_steps_are_not_shortened(cls):
    watched = Watched(lambda p: 100 * p[0] + p[1])
    watched.run(cls(), [1.0, 0.0])
    np.testing.assert_allclose(watched.batches[2][0], [1.0, 0.125])


@BOTH
@settings(max_examples=30)
@given(start=st.lists(st.floats(-1, 1), min_size=2, max_size=2), step=st.sampled_from([0.125, 0.5, 2.0]))
def test_it_is_clipped_at_the_box(cls, start, step):
    watched = Watched(lambda p: p.sum())
    outcome = watched.run(cls(step=step), start)
    assert all(np.abs(batch).max() <= 1.0 for batch in watched.batches)
    np.testing.assert_allclose(outcome.best, [1.0, 1.0], atol=1 / 32)


@BOTH
def test_nan_is_worse_than_anything(cls):
    outcome = Watched(lambda p: np.nan if p[0] > 0.1 else bowl(0.5, 0.0)(p)).run(cls(), [-0.5, 0.3])
    assert 0.0 <= outcome.best[0] <= 0.1


@BOTH
def test_beside_nan_it_still_climbs(cls):
    """All differences along x end in NaN on one side."""
    outcome = Watched(lambda p: np.nan if p[0] > 0.1 else bowl(0.09, 0.4)(p)).run(cls(), [0.09, -0.2])
    np.testing.assert_allclose(outcome.best, [0.09, 0.4], atol=1 / 16)


@BOTH
def test_a_start_without_value_is_left(cls):
    outcome = Watched(lambda p: np.nan if np.all(p == 0) else bowl(0.4, 0.0)(p)).run(cls())
    np.testing.assert_allclose(outcome.best, [0.4, 0.0], atol=1 / 32)


@BOTH
def test_without_any_value_it_stays(cls):
    outcome = Watched(lambda p: np.nan).run(cls(), [0.5, 0.5])
    np.testing.assert_allclose(outcome.best, [0.5, 0.5])


@BOTH
def test_the_best_point_of_a_difference_is_not_lost(cls):
    """A spike that only a difference meets: no step along the line is so short."""
    outcome = Watched(lambda p: p[0] == 0.03).run(cls(difference=0.03))
    np.testing.assert_allclose(outcome.best, [0.03, 0.0])


@BOTH
def test_nothing_to_see_is_the_end(cls):
    watched = Watched(lambda p: 1.0)
    assert watched.run(cls()).status is Status.CONVERGED
    assert len(watched.batches) == 2
