"""From rows to what is known of θ: a linear model, integrated in closed form for every prior that is compared.

Rows at θ = 0 are r₀, and r₀ + J θ + N ν is noise of known covariance: θ = c + d, c what the calibration left, d the
drift, ν nuisance parameters that belong to no rig. As everything is normal, c and ν are integrated once for each
calibration's κ and each deviation of the misfit, and what is left is a problem of the five extrinsics that drift.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._parameters import DRIFTING

_DRIFTING = len(DRIFTING)


@dataclass(frozen=True, eq=False)
class Normal:
    """A log likelihood: -½ (xᵀ a x - 2 bᵀ x + c), x being θ and, after it, nuisance parameters.

    Attributes:
        a: (n, n).
        b: (n,).
        c: with the logarithm of the determinant of the covariance of the rows.
    """

    a: Float[np.ndarray, "n n"]
    b: Float[np.ndarray, "n"]
    c: float

    def around(self, mean: Float[np.ndarray, "m"]) -> "Normal":
        """Of what the first parameters differ by from a mean."""
        by_mean = self.a[:, : len(mean)] @ mean
        return Normal(self.a, self.b - by_mean, self.c - float(mean @ (2.0 * self.b - by_mean)[: len(mean)]))

    def with_nuisance(self, number: int) -> "Normal":
        """Beside so many nuisance parameters of which it says nothing."""
        return Normal(np.pad(self.a, (0, number)), np.pad(self.b, (0, number)), self.c)

    def __add__(self, other: "Normal") -> "Normal":
        return Normal(self.a + other.a, self.b + other.b, self.c + other.c)


def normal_of(
    lower: Float[np.ndarray, "g g"], columns: Float[np.ndarray, "g n"], rows: Float[np.ndarray, "g"]
) -> Normal:
    """Of rows whose covariance is lower lowerᵀ."""
    from scipy.linalg import solve_triangular

    white = solve_triangular(lower, np.column_stack([columns, rows]), lower=True, check_finite=False)
    j, r = white[:, :-1], white[:, -1]
    return Normal(j.T @ j, -j.T @ r, float(r @ r + 2.0 * np.log(np.diag(lower)).sum()))


def without(of_rows: Normal, nuisance: Float[np.ndarray, "q q"]) -> Normal:
    """The likelihood of θ alone, the last parameters integrated.

    Args:
        nuisance: a root of their covariance.
    """
    n = len(of_rows.b) - len(nuisance)
    cross = nuisance.T @ np.column_stack([of_rows.a[n:, :n], of_rows.b[n:]])
    lower = np.linalg.cholesky(np.eye(len(nuisance)) + nuisance.T @ of_rows.a[n:, n:] @ nuisance)
    white = np.linalg.solve(lower, cross)
    of_theta, of_pull = white[:, :n], white[:, n]
    return Normal(
        of_rows.a[:n, :n] - of_theta.T @ of_theta,
        of_rows.b[:n] - of_theta.T @ of_pull,
        of_rows.c - float(of_pull @ of_pull) + 2.0 * float(np.log(np.diag(lower)).sum()),
    )


@dataclass(frozen=True, eq=False)
class Explained:
    """θ under each of k kinds of drift, one calibration's κ and one misfit.

    Attributes:
        log_evidence: (k,).
        means: (k, n).
        rest: (n, n) the covariance of θ if the drift were known.
        by_drift: (n, 5) how θ follows the drift.
        drifts: (k, 5, 5) covariances of the drift.
        nuisance: (k, q) means of the nuisance parameters.
    """

    log_evidence: Float[np.ndarray, "k"]
    means: Float[np.ndarray, "k n"]
    rest: Float[np.ndarray, "n n"]
    by_drift: Float[np.ndarray, "n 5"]
    drifts: Float[np.ndarray, "k 5 5"]
    nuisance: Float[np.ndarray, "k q"]

    def covariance(self, index: int) -> Float[np.ndarray, "n n"]:
        """Of θ under one of them."""
        return self.rest + self.by_drift @ self.drifts[index] @ self.by_drift.T


def explained(
    of_rows: Normal,
    calibration: Float[np.ndarray, "n n"],
    given: Float[np.ndarray, "n"],
    nuisance: Float[np.ndarray, "q q"],
    sizes: Float[np.ndarray, "k 5"],
    log_weights: Float[np.ndarray, "k"],
) -> Explained:
    """Integrate.

    Args:
        of_rows: of θ and q nuisance parameters.
        calibration: a root S of the covariance S Sᵀ of c.
        given: its mean.
        nuisance: a root of the covariance of the nuisance parameters.
        sizes: standard deviations of each kind of drift.
        log_weights: logarithms of their probabilities.
    """
    n, q = len(calibration), len(nuisance)
    of_rows = of_rows.around(given)
    prior = np.zeros((n + q, n + q))
    prior[:n, :n], prior[n:, n:] = calibration, nuisance
    pulled, by_prior = prior.T @ of_rows.b, of_rows.a @ prior
    inner = np.eye(n + q) + prior.T @ by_prior
    lower = np.linalg.cholesky(inner)
    # Without a drift, and how that follows one.
    solved = np.linalg.solve(inner, np.column_stack([pulled, by_prior[:_DRIFTING].T]))
    at_rest, follows = prior @ solved[:, 0], -prior @ solved[:, 1:]
    normal = of_rows.a[:_DRIFTING, :_DRIFTING] + by_prior[:_DRIFTING] @ -solved[:, 1:]
    pull = of_rows.b[:_DRIFTING] - by_prior[:_DRIFTING] @ solved[:, 0]
    inner_k = np.eye(_DRIFTING) + sizes[:, :, None] * (0.5 * (normal + normal.T)) * sizes[:, None, :]
    inverse_k = np.linalg.inv(inner_k)
    drifts = sizes[:, :, None] * inverse_k * sizes[:, None, :]
    d = drifts @ pull
    evidence = -0.5 * (of_rows.c - pulled @ solved[:, 0] + 2.0 * np.log(np.diag(lower)).sum())
    evidence = evidence - 0.5 * (np.linalg.slogdet(inner_k)[1] - d @ pull) + log_weights
    by_drift = follows[:n].copy()
    by_drift[:_DRIFTING] += np.eye(_DRIFTING)
    rest = prior[:n] @ np.linalg.solve(inner, prior[:n].T)
    return Explained(
        evidence,
        given + at_rest[:n] + d @ by_drift.T,
        0.5 * (rest + rest.T),
        by_drift,
        drifts,
        at_rest[n:] + d @ follows[n:].T,
    )
