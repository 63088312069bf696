"""The one least squares: Gauss-Newton on rows of groups, with the evidence choosing priors and misfit on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._evidence import Explained, Normal, explained, normal_of, without
from stereorecal.estimation._groups import PLACES, Groups, grouped
from stereorecal.estimation._misfit import COMMON, DEVIATIONS, alike, covariance_of_rows, unexpected
from stereorecal.estimation._posterior import Posterior, root
from stereorecal.objectives import RigChart
from stereorecal.scoring import Correspondences

_ROUNDS = 8
_REGROUPED = 3  # times; then outliers are what they are
_SETTLED = 0.05  # standard deviations of θ
_BOUND = 3.0  # standard deviations: beyond, a group that errs alone counts for less (Cauchy)
_NOTHING = np.zeros((0, 0))
_ROOT_OF_FIELD = root(alike(np.arange(PLACES[0] * PLACES[1])))
_LEAST = 1e-4  # of the weight of all explanations: below, one is dropped


@dataclass(frozen=True, eq=False)
class LinearRows:
    """The rows of groups near θ: r₀ + J θ.

    Attributes:
        groups: with frames, places and deviations.
        jacobian: (g, n).
        at_zero: (g,) r₀.
        deviation: (g,) pixels; larger than that of `groups` where a group errs alone.
        frames: indices of the groups of each frame.
    """

    groups: Groups
    jacobian: Float[np.ndarray, "g n"]
    at_zero: Float[np.ndarray, "g"]
    deviation: Float[np.ndarray, "g"]
    frames: Sequence[Int[np.ndarray, "f"]]

    def residual(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """At θ."""
        return self.at_zero + self.jacobian @ theta

    def normal(self, misfit: float) -> Normal:
        """The likelihood of θ and, where there are several frames, of a field over the places that they have in common,
        under a misfit of this deviation in each frame."""
        columns = self.jacobian if len(self.frames) == 1 else np.column_stack([self.jacobian, self._places])
        size = columns.shape[1]
        total = Normal(np.zeros((size, size)), np.zeros(size), 0.0)
        for f in self.frames:
            covariance = covariance_of_rows(self.groups.place[f], self.deviation[f], misfit)
            total = total + normal_of(np.linalg.cholesky(covariance), columns[f], self.at_zero[f])
        return total

    @property
    def _places(self) -> Float[np.ndarray, "g p"]:
        return np.eye(PLACES[0] * PLACES[1])[self.groups.place]

    def robust(self, misfit: float, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """The deviations that groups should have, if those that err alone at θ have a bounded say."""
        apart, residual = np.zeros(len(self.at_zero)), self.residual(theta)
        for f in self.frames:
            covariance = covariance_of_rows(self.groups.place[f], self.groups.deviation[f], misfit)
            apart[f] = unexpected(covariance, residual[f])
        return self.groups.deviation * np.sqrt(1.0 + (apart / _BOUND) ** 2)


@dataclass(frozen=True, eq=False)
class Explanation:
    """θ under a misfit and a calibration's prior, for all kinds of drift.

    Attributes:
        misfit: deviations of the field of each frame and of the common one, pixels.
        prior: which of the calibration's covariances.
        found: θ.
    """

    misfit: tuple[float, float]
    prior: int
    found: Explained


def explanations(
    rows: LinearRows, prior: CalibrationPrior, which: Sequence[int], misfits: Sequence[tuple[float, float]]
) -> list[Explanation]:
    """θ for each misfit and some of the covariances of the calibration's prior."""
    sizes, weights = drift_sizes()
    whole = {misfit: rows.normal(misfit) for misfit in {of_a_frame for of_a_frame, _ in misfits}}
    found = []
    for of_a_frame, common in misfits:
        normal = whole[of_a_frame]
        if len(rows.frames) > 1:
            normal = without(normal, common * _ROOT_OF_FIELD)
        for index in which:
            logs = np.log(weights * prior.weights[index])
            found.append(
                Explanation((of_a_frame, common), index, explained(normal, prior.roots[index], _NOTHING, sizes, logs))
            )
    return found


def best_of(several: Sequence[Explanation]) -> tuple[Explanation, int]:
    """The most probable one, and the kind of drift under which it is."""
    best = max(several, key=lambda one: float(one.found.log_evidence.max()))
    return best, int(best.found.log_evidence.argmax())


@dataclass(frozen=True, eq=False)
class Fit:
    """The solution.

    Attributes:
        posterior: of θ.
        rows: linear near it.
        misfit: the most probable deviations of the field of each frame and of the common one, pixels.
        prior: the most probable one of the calibration's covariances.
        prior_variance: (n,) of its error, before any image was seen, by the weights that its covariances have after.
    """

    posterior: Posterior
    rows: LinearRows
    misfit: tuple[float, float]
    prior: int
    prior_variance: Float[np.ndarray, "n"]


def fit(
    found: Correspondences, chart: RigChart, prior: CalibrationPrior, start: Float[np.ndarray, "n"] | None = None
) -> Fit:
    """Solve: a prior and a misfit for a round are the evidence's best, and all of them are mixed after the last.

    Args:
        found: with the rays that the cameras of the chart's rig give.
        start: θ to begin at; default 0.
    """
    theta = np.zeros(chart.dim) if start is None else start
    misfit, which = (DEVIATIONS[2], 0.0), len(prior.roots) // 2
    groups = grouped(found, chart, theta)
    rows = linear_rows(groups, chart, theta)
    for number in range(_ROUNDS):
        best, kind = best_of(_searched(rows, prior, misfit, which))
        mean, misfit, which = best.found.means[kind], best.misfit, best.prior
        moved = np.abs(mean - theta) / np.sqrt(np.maximum(np.diag(best.found.covariance(kind)), 1e-30))
        if moved.max() < _SETTLED:
            break
        grown, theta = rows.robust(sum(misfit), mean), mean
        if number < _REGROUPED:
            groups = grouped(found, chart, theta)
        rows = linear_rows(groups, chart, theta)
        if len(grown) == len(rows.deviation):
            rows = replace(rows, deviation=grown)
    near = _near(misfit, len(rows.frames) > 1)
    several = explanations(rows, prior, range(len(prior.roots)), near)
    evidence = np.array([np.logaddexp.reduce(one.found.log_evidence) for one in several])
    weights = np.exp(evidence - np.logaddexp.reduce(evidence))
    variances = np.stack([np.sum(prior.roots[one.prior] ** 2, axis=1) for one in several])
    return Fit(mixture(several), rows, misfit, which, weights @ variances)


def _searched(rows: LinearRows, prior: CalibrationPrior, misfit: tuple[float, float], which: int) -> list[Explanation]:
    """The best misfit for a prior, then the best prior for that misfit."""
    found = explanations(rows, prior, [which], [(d, misfit[1]) for d in DEVIATIONS])
    if len(rows.frames) > 1:
        here = best_of(found)[0].misfit[0]
        found += explanations(rows, prior, [which], [(here, c) for c in COMMON])
    best = best_of(found)[0]
    return found + explanations(rows, prior, range(len(prior.roots)), [best.misfit])


def _near(misfit: tuple[float, float], several: bool) -> list[tuple[float, float]]:
    """Misfits that are mixed: the best one and its neighbours."""

    def beside(value: float, grid: tuple[float, ...]) -> tuple[float, ...]:
        at = grid.index(value)
        return grid[max(at - 1, 0) : at + 2]

    return [(d, c) for d in beside(misfit[0], DEVIATIONS) for c in (beside(misfit[1], COMMON) if several else (0.0,))]


def linear_rows(groups: Groups, chart: RigChart, theta: Float[np.ndarray, "n"]) -> LinearRows:
    """Linear at θ."""
    rows = groups.rows(chart, theta)
    jacobian = rows.jacobian[:, 0].T
    frames = [np.flatnonzero(groups.frame == frame) for frame in np.unique(groups.frame)]
    return LinearRows(groups, jacobian, rows.differences[0] - jacobian @ theta, groups.deviation, frames)


def mixture(several: Sequence[Explanation]) -> Posterior:
    """All explanations, each with its weight; what hardly weighs is left out."""
    evidence = np.stack([one.found.log_evidence for one in several])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    kept = np.argwhere(weights > _LEAST)
    some = weights[tuple(kept.T)]
    return Posterior(
        some / some.sum(),
        np.stack([several[i].found.means[k] for i, k in kept]),
        np.stack([several[i].found.covariance(int(k)) for i, k in kept]),
    )
