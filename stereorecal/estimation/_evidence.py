"""From rows to what is known of θ: a linear model, integrated in closed form for every prior that is compared.

Rows at θ = 0 are r₀, and r₀ + J θ + N ν is noise of known covariance: θ = c + d, c what the calibration left, d the
drift, ν nuisance parameters that belong to no rig. As everything is normal, c and ν are integrated once for each
calibration's κ and each deviation of the misfit, and what is left is a problem of the five extrinsics that drift.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._rig_parameters import DRIFTING

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

    @classmethod
    def flat(cls, n: int) -> "Normal":
        """That of something which tells nothing."""
        return cls(np.zeros((n, n)), np.zeros(n), 0.0)

    def of_parameters(self, to: Float[np.ndarray, "n m"]) -> "Normal":
        """The likelihood of parameters p with x = to p."""
        return Normal(to.T @ self.a @ to, to.T @ self.b, self.c)

    def of(self, which: Int[np.ndarray, "m"]) -> "Normal":
        """That of some of the parameters, the others 0; or of all in another order."""
        return Normal(self.a[np.ix_(which, which)], self.b[which], self.c)

    def around(self, mean: Float[np.ndarray, "m"]) -> "Normal":
        """The likelihood of what the first parameters differ by from a mean."""
        by_mean = self.a[:, : len(mean)] @ mean
        return Normal(self.a, self.b - by_mean, self.c - float(mean @ (2.0 * self.b - by_mean)[: len(mean)]))

    def with_nuisance(self, number: int) -> "Normal":
        """The same beside so many nuisance parameters, of which it says nothing."""
        n = len(self.b)
        a, b = np.zeros((n + number, n + number)), np.zeros(n + number)
        a[:n, :n], b[:n] = self.a, self.b  # np.pad took a twentieth of a repair
        return Normal(a, b, self.c)

    def __sub__(self, other: "Normal") -> "Normal":
        return Normal(self.a - other.a, self.b - other.b, self.c - other.c)

    def __add__(self, other: "Normal") -> "Normal":
        return Normal(self.a + other.a, self.b + other.b, self.c + other.c)


def normal_of(
    columns: Float[np.ndarray, "g n"], rows: Float[np.ndarray, "g"], deviation: Float[np.ndarray, "g"]
) -> Normal:
    """The likelihood by rows that err each by itself."""
    j, r = columns / deviation[:, None], rows / deviation
    return Normal(j.T @ j, -j.T @ r, float(r @ r + 2.0 * np.log(deviation).sum()))


def marginal(normal: Normal, root: Float[np.ndarray, "q r"]) -> Normal:
    """The likelihood of the others, the last q parameters integrated, of whose covariance this is a root."""
    n = len(normal.b) - len(root)
    cross = root.T @ np.column_stack([normal.a[n:, :n], normal.b[n:]])
    others = Normal(normal.a[:n, :n], normal.b[:n], normal.c)
    return integrated(others, cross, root.T @ normal.a[n:, n:] @ root)


def integrated(others: Normal, cross: Float[np.ndarray, "q m"], own: Float[np.ndarray, "q q"]) -> Normal:
    """The likelihood of n parameters, q more integrated, which are independent and 1 large.

    Args:
        others: the likelihood if these were 0.
        cross: (q, n + 1) the rows of `a` and of `b` that are theirs.
        own: their part of `a`.
    """
    (q, m), whole = cross.shape, np.zeros((sum(cross.shape),) * 2)
    whole[:q, :q], whole[q:, :q] = np.eye(q) + own, cross.T
    whole[q:, q:] = (1.0 + float(np.vdot(cross, cross))) * np.eye(m)  # any that leaves it positive
    lower = np.linalg.cholesky(whole)  # and solves for `cross`: NumPy has no triangular solve, and SciPy starts slowly
    of_theta, of_pull = lower[q:-1, :q], lower[-1, :q]
    return Normal(
        others.a - of_theta @ of_theta.T,
        others.b - of_theta @ of_pull,
        others.c - float(of_pull @ of_pull) + 2.0 * float(np.log(np.diag(lower)[:q]).sum()),
    )


@dataclass(frozen=True, eq=False)
class Nuisances:
    """Parameters ν beside θ, which belong to no rig: normal, around 0.

    Attributes:
        sizes: (q,) their standard deviations.
        log_prior: natural logarithm of the probability that there are these.
    """

    sizes: Float[np.ndarray, "q"]
    log_prior: float


ALONE = Nuisances(np.zeros(0), 0.0)  # the rig, and nothing beside it


@dataclass(frozen=True, eq=False)
class Explanation:
    """θ under a misfit and one calibration's κ, for each of k kinds of drift.

    Attributes:
        misfit: deviations of the field of each frame and of the common one, pixels.
        prior: which of the calibration's covariances.
        of_rows: the likelihood of θ and ν that this rests on.
        nuisances: what ν is.
        log_evidence: (k,).
        most: the largest of these.
        without_drift: (n + q,) the mean of θ and ν if there were no drift.
        by_drift: (n + q, 5) how they follow the drift.
        drifts: (k, 5) means of the drift.
        precision: (5, 5) of the drift, by the rows alone.
        sizes: (k, 5) standard deviations of each kind of drift.
        calibration: (n, n) a root of the covariance of c, and
        lower: (n + q, n + q) the Cholesky factor of the precision of c and ν that the rows leave, in units of roots.
    """

    misfit: tuple[float, float]
    prior: int
    of_rows: Normal
    nuisances: Nuisances
    log_evidence: Float[np.ndarray, "k"]
    most: float
    without_drift: Float[np.ndarray, "m"]
    by_drift: Float[np.ndarray, "m 5"]
    drifts: Float[np.ndarray, "k 5"]
    precision: Float[np.ndarray, "5 5"]
    sizes: Float[np.ndarray, "k 5"]
    calibration: Float[np.ndarray, "n n"]
    lower: Float[np.ndarray, "m m"]

    @property
    def means(self) -> Float[np.ndarray, "k n"]:
        """The means of θ."""
        return self._all_means[:, : len(self.calibration)]

    @property
    def nuisance_means(self) -> Float[np.ndarray, "k q"]:
        """Means of ν."""
        return self._all_means[:, len(self.calibration) :]

    @property
    def best(self) -> int:
        """The kind of drift under which it is most probable."""
        return int(self.log_evidence.argmax())

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """The mean of θ under that."""
        return self.means[self.best]

    @cached_property
    def _all_means(self) -> Float[np.ndarray, "k m"]:
        return self.without_drift + self.drifts @ self.by_drift.T

    @cached_property
    def _covariance_without_drift(self) -> Float[np.ndarray, "n n"]:
        """The covariance of θ if the drift were known."""
        n = len(self.calibration)
        half = np.linalg.solve(self.lower, np.eye(len(self.lower), n) @ self.calibration.T)
        return half.T @ half

    def covariances(self, which: Int[np.ndarray, "s"]) -> Float[np.ndarray, "s n n"]:
        """Covariances of θ under some kinds of drift."""
        across, down = self.sizes[which][:, None], self.sizes[which][:, :, None]
        drift = down * np.linalg.inv(np.eye(_DRIFTING) + down * self.precision * across) * across
        follows = self.by_drift[: len(self.calibration)]
        return self._covariance_without_drift + follows @ (0.5 * (drift + drift.swapaxes(1, 2))) @ follows.T


def all_explained(
    told: Sequence[tuple[tuple[float, float], float, Normal]],
    which: Sequence[int],
    prior: Mixture,
    nuisances: Nuisances,
    drifts: tuple[Float[np.ndarray, "k 5"], Float[np.ndarray, "k"]],
) -> list[Explanation]:
    """Integrate each of several likelihoods under each of some of the calibration's covariances.

    Args:
        told: of each the misfit, the logarithm of its probability, and the likelihood of θ and ν.
        which: of the covariances.
        drifts: standard deviations of each kind of drift, and their probabilities.
    """
    sizes, weights = drifts
    each, index = np.repeat(np.arange(len(told)), len(which)), np.tile(which, len(told))
    calibrations, prior_mean = prior.roots[index], prior.means[index]
    log_weights = np.log(weights * prior.weights[index, None]) + np.array([log for _, log, _ in told])[each, None]
    n, q = prior.means.shape[1], len(nuisances.sizes)
    a, b, c = (np.stack([np.asarray(getattr(one, name)) for *_, one in told])[each] for name in "abc")
    by_mean = (a[:, :, :n] @ prior_mean[:, :, None])[:, :, 0]
    c = c - np.einsum("jn,jn->j", prior_mean, (2.0 * b - by_mean)[:, :n])
    b = b - by_mean
    # With θ and ν in units of their roots.
    roots = np.zeros((len(index), n + q, n + q))
    roots[:, :n, :n], roots[:, n:, n:] = calibrations, np.diag(nuisances.sizes)
    turned, by_root = roots.swapaxes(1, 2), a @ roots
    pulled, inner = turned @ b[:, :, None], np.eye(n + q) + turned @ by_root
    lower = np.linalg.cholesky(inner)
    # Without a drift, and how that follows one.
    of_drift = by_root[:, :_DRIFTING]
    solved = np.linalg.solve(inner, np.concatenate([pulled, of_drift.swapaxes(1, 2)], axis=2))
    without_drift, drift_response = roots @ solved[:, :, :1], -roots @ solved[:, :, 1:]
    precision = a[:, :_DRIFTING, :_DRIFTING] - of_drift @ solved[:, :, 1:]
    precision = 0.5 * (precision + precision.swapaxes(1, 2))
    pull = b[:, :_DRIFTING] - (of_drift @ solved[:, :, :1])[:, :, 0]
    means, information = _of_drifts(precision, pull, sizes)
    at_zero = c - (pulled * solved[:, :, :1]).sum(axis=(1, 2))
    at_zero += 2.0 * np.log(np.diagonal(lower, axis1=1, axis2=2)).sum(axis=1)
    evidence = log_weights - 0.5 * (at_zero[:, None] + information - (means @ pull[:, :, None])[:, :, 0])
    most, without_drift = evidence.max(axis=1).tolist(), without_drift[:, :, 0]
    without_drift[:, :n] += prior_mean
    by_drift = drift_response + np.eye(n + q, _DRIFTING)
    found = zip(evidence, most, without_drift, by_drift, means, precision, calibrations, lower, strict=True)
    return [
        Explanation(misfit, one, normal, nuisances, e, m, w, by, d, p, sizes, root, half)
        for ((misfit, _, normal), one), (e, m, w, by, d, p, root, half) in zip(product(told, which), found, strict=True)
    ]


def _of_drifts(
    precision: Float[np.ndarray, "j 5 5"], pull: Float[np.ndarray, "j 5"], sizes: Float[np.ndarray, "k 5"]
) -> tuple[Float[np.ndarray, "j k 5"], Float[np.ndarray, "j k"]]:
    """The mean of the drift for each kind of it, and the logarithm of the determinant of 1 + s M s: elimination in all
    of these thousands of small matrices together, entry by entry of their lower halves, which a cache holds. They are
    positive definite and 1 at least, so no pivot is small."""
    of_axis, axes = sizes.T, range(_DRIFTING)
    lower = {
        (i, j): precision[:, i, j, None] * (of_axis[i] * of_axis[j]) + (i == j) for i in axes for j in range(i + 1)
    }
    rhs = [pull[:, i, None] * of_axis[i] for i in axes]
    for p in axes:
        for i in range(p + 1, _DRIFTING):
            share = lower[i, p] / lower[p, p]
            for j in range(p + 1, i + 1):
                lower[i, j] -= share * lower[j, p]
            rhs[i] -= share * rhs[p]
    for p in reversed(axes):
        for i in range(p + 1, _DRIFTING):
            rhs[p] -= lower[i, p] * rhs[i]
        rhs[p] /= lower[p, p]
    logs = np.sum([np.log(lower[p, p]) for p in axes], axis=0)
    return np.stack([of_axis[i] * rhs[i] for i in axes], axis=-1), logs
