"""Closed forms against dense conditioning of normal distributions, written out."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import Explanation, Nuisances, all_explained, marginal, normal_of, updated

from stereorecal.estimation import Mixture, Normal

ROWS, DRIFTING = 14, 5


def explained(problems: list["Problem"]) -> list[Explanation]:
    """θ of each problem, which have the same nuisance parameters and kinds of drift."""
    first, number = problems[0], len(problems)
    calibrations, given = np.stack([p.calibration for p in problems]), np.stack([p.given for p in problems])
    every = all_explained(
        [((0.0, 0.0), 0.0, problem.normal) for problem in problems],
        range(number),
        Mixture(np.ones(number), given, calibrations @ calibrations.swapaxes(1, 2)),
        Nuisances(first.nuisance, 0.0),
        (first.sizes, np.exp(first.logs)),
    )
    return every[:: number + 1]  # of each its own calibration


def by_rows(covariance: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> Normal:
    """The likelihood by rows with this covariance, written out."""
    precision = np.linalg.inv(covariance)
    pull = precision @ rows
    return Normal(columns.T @ precision @ columns, -columns.T @ pull, rows @ pull + np.linalg.slogdet(covariance)[1])


class Problem:
    """Rows r₀ + J θ + N ν = noise, θ = c + d."""

    def __init__(self, seed: int, n: int = 8, q: int = 3, rank: int | None = None) -> None:
        rng = np.random.default_rng(seed)
        self.n, self.q = n, q
        self.columns = rng.normal(0, 1, (ROWS, n + q))
        self.rows = rng.normal(0, 2, ROWS)
        noise = rng.normal(0, 1, (ROWS, ROWS))
        self.noise = noise @ noise.T + 0.1 * np.eye(ROWS)
        self.calibration = rng.normal(0, 0.5, (n, n))
        self.calibration[:, n if rank is None else rank :] = 0.0
        self.given = rng.normal(0, 0.5, n)
        self.nuisance = rng.uniform(0.1, 1.5, q)
        self.sizes = np.array([np.zeros(5), rng.uniform(0, 1, 5), [0, 2.0, 0, 0, 0]])
        self.logs = np.log([0.5, 0.3, 0.2])

    @property
    def normal(self) -> Normal:
        return by_rows(self.noise, self.columns, self.rows)

    def found(self):
        return explained([self])[0]

    def dense(self, kind: int) -> tuple[np.ndarray, np.ndarray, float]:
        """Mean and covariance of θ and ν given the rows, and the logarithm of the rows' density."""
        prior = np.zeros((self.n + self.q, self.n + self.q))
        prior[: self.n, : self.n] = self.calibration @ self.calibration.T
        prior[self.n :, self.n :] = np.diag(self.nuisance**2)
        prior[:DRIFTING, :DRIFTING] += np.diag(self.sizes[kind] ** 2)
        expected = np.r_[self.given, np.zeros(self.q)]
        rows = self.rows + self.columns @ expected
        of_rows = self.noise + self.columns @ prior @ self.columns.T
        gain = np.linalg.solve(of_rows, self.columns @ prior).T
        density = -0.5 * (rows @ np.linalg.solve(of_rows, rows) + np.linalg.slogdet(of_rows)[1])
        return expected - gain @ rows, prior - gain @ self.columns @ prior, density


shapes = {"seed": st.integers(0, 9999), "n": st.integers(5, 9), "q": st.integers(0, 4), "rank": st.integers(0, 9)}


@settings(max_examples=60)
@given(**shapes)
def test_dense_conditioning_says_the_same(seed, n, q, rank):
    """Singular priors too: rank 0 is a calibration that is exact."""
    problem = Problem(seed, n, q, rank)
    found = problem.found()
    for kind, log in enumerate(problem.logs):
        mean, covariance, density = problem.dense(kind)
        np.testing.assert_allclose(found.means[kind], mean[:n], rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(found.nuisance_means[kind], mean[n:], rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(found.covariances(np.array([kind]))[0], covariance[:n, :n], rtol=1e-6, atol=1e-8)
        assert found.log_evidence[kind] == pytest.approx(density + log, rel=1e-9, abs=1e-7)


@settings(max_examples=40)
@given(**shapes)
def test_what_is_integrated_is_noise_of_the_rows(seed, n, q, rank):
    problem = Problem(seed, n, q)
    nuisance = np.random.default_rng(seed).normal(0, 0.7, (q, rank))
    pulls = problem.columns[:, n:] @ nuisance
    expected = by_rows(problem.noise + pulls @ pulls.T, problem.columns[:, :n], problem.rows)
    found = marginal(problem.normal, nuisance)
    np.testing.assert_allclose(found.a, expected.a, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(found.b, expected.b, rtol=1e-6, atol=1e-8)
    assert found.c == pytest.approx(expected.c, rel=1e-9)


def test_likelihoods_of_independent_rows_add():
    problem, deviation = Problem(4), np.linspace(0.1, 2, ROWS)
    whole = by_rows(np.diag(deviation**2), problem.columns, problem.rows)
    parts = [normal_of(problem.columns[s], problem.rows[s], deviation[s]) for s in (slice(0, 5), slice(5, None))]
    both = parts[0] + parts[1]
    np.testing.assert_allclose(both.a, whole.a)
    np.testing.assert_allclose(both.b, whole.b)
    assert both.c == pytest.approx(whole.c)


@settings(max_examples=20)
@given(seeds=st.lists(st.integers(0, 99), min_size=1, max_size=5), q=st.integers(0, 3))
def test_several_at_once_are_each_alone(seeds, q):
    problems = [Problem(seed, q=q) for seed in seeds]
    for problem in problems:
        problem.nuisance, problem.sizes = problems[0].nuisance, problems[0].sizes
    for problem, one in zip(problems, explained(problems), strict=True):
        alone = problem.found()
        np.testing.assert_allclose(one.log_evidence, alone.log_evidence, rtol=1e-10, atol=1e-9)
        np.testing.assert_allclose(one.means, alone.means, rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(one.nuisance_means, alone.nuisance_means, rtol=1e-8, atol=1e-9)
        which = np.arange(3)
        np.testing.assert_allclose(one.covariances(which), alone.covariances(which), rtol=1e-8, atol=1e-9)


@settings(max_examples=20)
@given(seed=st.integers(0, 9999), number=st.integers(1, 4))
def test_a_mixture_is_updated_as_each_of_its_parts_conditioned(seed, number):
    """And each part's weight by how well it had foretold the rows."""
    parts = [Problem(seed + index, q=0) for index in range(number)]
    for part in parts:  # one likelihood for all of them
        part.columns, part.rows, part.noise = parts[0].columns, parts[0].rows, parts[0].noise
    weights = np.arange(1.0, number + 1.0) / np.arange(1.0, number + 1.0).sum()
    calibrations = np.stack([part.calibration for part in parts])
    prior = Mixture(weights, np.stack([part.given for part in parts]), calibrations @ calibrations.swapaxes(1, 2))
    found, dense = updated(prior, parts[0].normal), [part.dense(0) for part in parts]
    logs = np.log(weights) + [density for *_, density in dense]
    np.testing.assert_allclose(found.weights, np.exp(logs - np.logaddexp.reduce(logs)), rtol=1e-6, atol=1e-12)
    for mean, covariance, (expected, of_dense, _) in zip(found.means, found.covariances, dense, strict=True):
        np.testing.assert_allclose(mean, expected, rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(covariance, of_dense, rtol=1e-6, atol=1e-8)
