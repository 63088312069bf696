"""What stays together in a region against what errs alone."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import correlation, covariance_of_rows, unexpected

from stereorecal.estimation import PLACES

EVERY = np.arange(PLACES[0] * PLACES[1])
LEFT = EVERY % PLACES[0] < 5


def test_neighbours_err_alike_and_the_far_ones_do_not():
    found = correlation(EVERY)
    np.testing.assert_array_equal(np.diag(found), 1.0)
    assert found[0, 1] == found[0, PLACES[0]] > 0.7  # a column on, a row on
    assert found[0, 4] < 0.05
    assert found[PLACES[0] - 1, PLACES[0]] < 1e-6  # the end of a row is far from the start of the next
    assert np.linalg.eigvalsh(found).min() > -1e-12


@settings(max_examples=20)
@given(seed=st.integers(0, 999), misfit=st.sampled_from([0.0, 0.07, 0.8]))
def test_unexpected_is_what_all_others_leave(seed, misfit):
    """Written out: each group predicted from the rest."""
    rng = np.random.default_rng(seed)
    place, residual = np.sort(rng.choice(EVERY, 12)), rng.normal(0, 0.3, 12)
    covariance = covariance_of_rows(place, rng.uniform(0.03, 0.2, 12), misfit)
    expected = []
    for one in range(12):
        rest = np.arange(12) != one
        pull = np.linalg.solve(covariance[np.ix_(rest, rest)], covariance[rest, one])
        expected.append(
            (residual[one] - pull @ residual[rest]) / np.sqrt(covariance[one, one] - pull @ covariance[rest, one])
        )
    np.testing.assert_allclose(unexpected(covariance, residual), expected, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("size", [0.2, 0.4])
def test_a_region_that_moved_as_a_whole_is_expected_and_a_group_alone_is_not(size):
    covariance = covariance_of_rows(EVERY, np.full(len(EVERY), 0.05), size)
    assert np.abs(unexpected(covariance, size * LEFT)).max() < 3.0
    alone = np.abs(unexpected(covariance, size * (EVERY == 60)))
    assert alone[60] > 3.0
    assert alone.argmax() == 60
