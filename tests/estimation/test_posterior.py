"""Mixtures: moments and samples say the same."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import merged

from stereorecal.estimation import Mixture

UNITS = np.array([1e-6, 1.0, 1e3, 0.05])


def covariance(seed: int, rank: int) -> np.ndarray:
    """A covariance of parameters in very different units."""
    half = np.random.default_rng(seed).normal(0, 1, (4, rank)) * UNITS[:, None]
    return half @ half.T


def mixture() -> Mixture:
    means = np.random.default_rng(1).normal(0, 2, (3, 4)) * UNITS
    return Mixture(np.array([0.6, 0.3, 0.1]), means, np.stack([covariance(rank, rank) for rank in (4, 2, 0)]))


def test_moments_are_those_of_many_samples():
    found = mixture()
    drawn = found.samples(100_000, 3)
    np.testing.assert_allclose(drawn.mean(axis=0) / UNITS, found.mean / UNITS, atol=0.03)
    np.testing.assert_allclose(
        np.cov(drawn.T) / np.outer(UNITS, UNITS), found.covariance / np.outer(UNITS, UNITS), atol=0.15
    )


@given(seed=st.integers(0, 999), rank=st.integers(0, 4))
def test_samples_of_singular_covariances(seed, rank):
    """Those of the identity, turned and scaled: they say by which root of the covariance."""
    wanted = covariance(seed, rank)
    white, drawn = (Mixture(np.ones(1), np.zeros((1, 4)), one[None]).samples(20, seed) for one in (np.eye(4), wanted))
    half = np.linalg.lstsq(white, drawn / UNITS, rcond=None)[0].T
    np.testing.assert_allclose(half @ half.T, wanted / np.outer(UNITS, UNITS), atol=1e-12)


def many(seed: int, number: int = 60) -> Mixture:
    """Explanations of which some are alike, one parameter exact."""
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.full(number, 0.3))
    means = rng.integers(-2, 3, (number, 1)) * np.array([1.0, 0.5, -1.0, 0.0]) + rng.normal(0, 0.05, (number, 4))
    scales = np.exp(rng.uniform(-1.5, 1.0, (number, 1, 1)))
    kinds = [covariance(kind, 3) / np.outer(UNITS, UNITS) for kind in (1, 2)]
    exact = np.array([1.0, 1.0, 1.0, 0.0])
    covariances = scales * np.stack([kinds[index % 2] for index in range(number)]) * np.outer(exact, exact)
    return Mixture(weights, means * exact * UNITS, covariances * np.outer(UNITS, UNITS))


@given(seed=st.integers(0, 999), most=st.integers(1, 70))
def test_explanations_that_become_one_keep_mean_and_covariance(seed, most):
    whole = many(seed)
    fewer = merged(whole, most)
    assert len(fewer.weights) <= most
    assert fewer.weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(fewer.mean / UNITS, whole.mean / UNITS, atol=1e-9)
    scale = np.outer(UNITS, UNITS)
    np.testing.assert_allclose(fewer.covariance / scale, whole.covariance / scale, atol=1e-9)


@settings(max_examples=10)
@given(seed=st.integers(0, 999))
def test_and_nearly_all_quantiles(seed):
    whole, levels = many(seed), [2.5, 25, 50, 75, 97.5]
    fewer = merged(whole, 30)
    directions = np.random.default_rng(seed).normal(0, 1, (4, 5)) / UNITS[:, None]
    one, other = (np.percentile(each.samples(40_000, 1) @ directions, levels, axis=0) for each in (whole, fewer))
    deviation = np.sqrt(np.einsum("nd,nm,md->d", directions, whole.covariance, directions))
    assert np.abs((other - one) / deviation).max() < 0.12


def test_each_explanation_has_its_share_of_the_samples():
    """To one draw: what is rare must not be rarer, or more frequent, by chance."""
    weights, means = np.array([0.9, 0.0945, 0.0055]), np.array([[0.0], [100.0], [200.0]])
    found = Mixture(weights, means, np.full((3, 1, 1), 1e-6)).samples(2000)[:, 0]
    counts = [np.count_nonzero(np.abs(found - mean) < 1.0) for mean in (0.0, 100.0, 200.0)]
    np.testing.assert_allclose(counts, 2000 * weights, atol=1.0)
