"""Compass search: it conforms, and it is the paper's."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from stereorecal_compass import Compass
from watched import Watched

from stereorecal.strategies import Status
from stereorecal.testing import StrategyConformance


class TestCompass(StrategyConformance):
    strategy = Compass()


@pytest.mark.parametrize(
    "options", [(0.1, 0.2), (0.1, 0.0), (0.1, -1.0), (3.0, 0.1), (np.nan, 0.1), (0.1, np.nan), (0, 0)]
)
def test_options_that_make_no_sense(options):
    with pytest.raises(ValueError, match="need 0 < min_step <= step <= 2"):
        Compass(*options)


def test_it_moves_to_the_best_of_2n_and_halves_without_strict_improvement():
    """By hand, on a grid of quarters: values of a table, 0 elsewhere."""
    table = {
        (0.0, 0.0): 1,
        (0.25, 0.0): 2,
        (0.0, 0.25): 3,
        (-0.25, 0.0): 2,
        (0.0, 0.5): 3,
        (0.25, 0.25): 3,
        (0.125, 0.25): 4,
    }
    watched = Watched(lambda p: table.get(tuple(np.round(p, 9)), 0))
    outcome = watched.run(Compass(step=0.25, min_step=0.125))
    # (0, 0) -> (0, 0.25), the best of four; then two ties, which are no improvement: half the step -> (0.125, 0.25);
    # then nothing better: half the step again, below min_step: the end. No point is asked twice.
    expected = [
        [(0.25, 0), (0, 0.25), (-0.25, 0), (0, -0.25)],
        [(0.25, 0.25), (0, 0.5), (-0.25, 0.25)],
        [(0.125, 0.25), (0, 0.375), (-0.125, 0.25), (0, 0.125)],
        [(0.125, 0.375), (0.125, 0.125)],
    ]
    assert [len(b) for b in watched.batches] == [1, 4, 3, 4, 2]
    for batch, points in zip(watched.batches[1:], expected, strict=True):
        np.testing.assert_allclose(batch, points)
    np.testing.assert_allclose(outcome.best, [0.125, 0.25])
    assert outcome.status is Status.CONVERGED


def test_the_step_never_grows():
    watched = Watched(lambda p: -np.abs(p - 0.9).sum())
    watched.run(Compass(step=0.5, min_step=1 / 64))
    steps, best = [], watched.batches[0][0]
    for batch in watched.batches[1:]:
        steps.append(np.abs(batch - best).max())
        best = max([best, *batch], key=lambda p: -np.abs(p - 0.9).sum())
    assert all(later <= earlier + 1e-12 for earlier, later in pairwise(steps))
    assert min(steps) < 1 / 32


@pytest.mark.parametrize("dim", [1, 3, 5])
def test_every_iteration_is_one_batch_of_new_points(dim):
    watched = Watched(lambda p: -np.sum((p - 0.3) ** 2), dim)
    watched.run(Compass())
    sizes = [len(batch) for batch in watched.batches]
    assert sizes[:2] == [1, 2 * dim]
    assert max(sizes) == 2 * dim
    asked = np.concatenate(watched.batches)
    assert len(np.unique(asked, axis=0)) == len(asked)


def test_in_a_corner_of_the_box_little_is_new():
    watched = Watched(lambda p: p.sum())
    watched.run(Compass(step=0.5, min_step=0.25), [1.0, 1.0])
    assert [len(batch) for batch in watched.batches] == [1, 2, 2]


@given(start=st.lists(st.floats(-1, 1), min_size=2, max_size=2), step=st.sampled_from([0.125, 0.5, 2.0]))
def test_it_is_clipped_at_the_box(start, step):
    watched = Watched(lambda p: p.sum())
    outcome = watched.run(Compass(step=step), start)
    assert all(np.abs(batch).max() <= 1.0 for batch in watched.batches)
    np.testing.assert_allclose(outcome.best, [1.0, 1.0], atol=1 / 64)


def test_nan_is_worse_than_anything():
    watched = Watched(lambda p: np.nan if p[0] > 0.1 else -abs(p[0] - 0.5) - abs(p[1]))
    outcome = watched.run(Compass(), [-0.5, 0.2])
    assert outcome.best[0] <= 0.1
    assert outcome.best[0] > 0.05


def test_a_start_without_value_is_left():
    outcome = Watched(lambda p: np.nan if np.all(p == 0) else -np.abs(p).sum()).run(Compass())
    assert np.any(outcome.best != 0)
