"""What stays together in a region against what errs alone."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import Model, correlation, covariance_of_rows, grouped, unexpected

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


@pytest.mark.parametrize("misfit", [(0.0, 0.0), (0.07, 0.0), (0.4, 0.0), (0.07, 0.12), (0.0, 0.2)])
@pytest.mark.parametrize("frames", [1, 3])
def test_rows_under_a_misfit_are_those_of_their_whole_covariance(rig, chart, prior, seen, frames, misfit):
    """A field of each frame, and one that all have in common, written out group by group."""
    found = seen(rig, chart.rig_at(np.r_[0.1, 0.05, -0.1, 0.1, -0.2, np.zeros(chart.dim - 5)]), frames=frames)
    rows = Model(chart, prior).linear(grouped(found, chart, np.zeros(chart.dim)), np.zeros(chart.dim))
    place, frame, (own, common) = rows.groups.place, rows.groups.frame, misfit
    together = own**2 * (frame[:, None] == frame) + common**2 * (frames > 1)
    covariance = together * correlation(place) + np.diag(rows.deviation**2)
    precision = np.linalg.inv(covariance)
    told, jacobian = rows.normal(misfit if frames > 1 else (own, 0.0)), rows.jacobian
    sizes = np.sqrt(np.diag(prior.covariance))
    expected = sizes[:, None] * (jacobian.T @ precision @ jacobian) * sizes
    np.testing.assert_allclose(sizes[:, None] * told.a * sizes, expected, rtol=1e-6, atol=1e-9 * expected.max())
    np.testing.assert_allclose(told.b, -jacobian.T @ precision @ rows.at_zero, rtol=1e-6)
    c = rows.at_zero @ precision @ rows.at_zero + np.linalg.slogdet(covariance)[1]
    assert told.c == pytest.approx(c, rel=1e-8)
    assert len(pickle.dumps(rows)) == len(pickle.dumps(replace(rows)))  # to workers, without what is derived
