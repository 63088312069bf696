"""Rows of groups, linear near a rig, and θ under every prior and misfit that is compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._evidence import Explained, Normal, all_explained, normal_of, without
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._measured import NOTHING_ELSE, Measured
from stereorecal.estimation._misfit import alike, covariance_of_rows, unexpected
from stereorecal.estimation._posterior import root
from stereorecal.objectives import RigChart

_BOUND = 3.0  # standard deviations: beyond, a group that errs alone counts for less (Cauchy)
NOTHING = np.zeros((0, 0))
_ROOT_OF_FIELD = root(alike(np.arange(PLACES[0] * PLACES[1])))


@dataclass(frozen=True, eq=False)
class LinearRows:
    """The rows of groups near θ: r₀ + J θ.

    Attributes:
        groups: with frames, places and deviations.
        jacobian: (g, n).
        at_zero: (g,) r₀.
        deviation: (g,) pixels; larger than that of `groups` where a group errs alone.
        frames: indices of the groups of each frame.
        measured: ranges and windows.
        told: what these may tell of θ, as `Measured.told` has it.
    """

    groups: Groups
    jacobian: Float[np.ndarray, "g n"]
    at_zero: Float[np.ndarray, "g"]
    deviation: Float[np.ndarray, "g"]
    frames: Sequence[Int[np.ndarray, "_"]]
    measured: Measured
    told: Sequence[tuple[float, Normal]]

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
        of_rows: the likelihood of θ, and of nuisance parameters after it, that this rests on.
        nuisance: a root of the covariance of those.
    """

    misfit: tuple[float, float]
    prior: int
    found: Explained
    of_rows: Normal
    nuisance: Float[np.ndarray, "q q"]


def explanations(
    rows: LinearRows,
    prior: CalibrationPrior,
    which: Sequence[int],
    misfits: Sequence[tuple[float, float]],
    nuisance: Float[np.ndarray, "q q"] = NOTHING,
    log_prior: float = 0.0,
) -> list[Explanation]:
    """θ for each misfit and some of the covariances of the calibration's prior.

    Args:
        rows: whose last columns are nuisance parameters.
        nuisance, log_prior: as `explained_by` has them.
    """
    whole = {misfit: rows.normal(misfit) for misfit in {of_a_frame for of_a_frame, _ in misfits}}
    if len(rows.frames) > 1:
        normals = [without(whole[of_a_frame], common * _ROOT_OF_FIELD) for of_a_frame, common in misfits]
    else:
        normals = [whole[of_a_frame] for of_a_frame, _ in misfits]
    return explained_by(dict(zip(misfits, normals, strict=True)), rows.told, prior, which, nuisance, log_prior)


def explained_by(
    normals: Mapping[tuple[float, float], Normal],
    told: Sequence[tuple[float, Normal]],
    prior: CalibrationPrior,
    which: Sequence[int],
    nuisance: Float[np.ndarray, "q q"] = NOTHING,
    log_prior: float = 0.0,
) -> list[Explanation]:
    """θ for each misfit, with what else may be told, under some of the covariances of the calibration's prior and all
    kinds of drift.

    Args:
        normals: the likelihood of rows under each misfit.
        told: as `Measured.told` has it; of nuisance parameters, too, or of θ alone.
        nuisance: a root of the covariance of what the likelihoods have besides θ.
        log_prior: logarithm of its probability.
    """
    sizes, weights = drift_sizes()
    every = [
        (misfit, index, log_told + log_prior, of_rows + of_others.with_nuisance(len(of_rows.b) - len(of_others.b)))
        for (misfit, of_rows), (log_told, of_others), index in product(normals.items(), told, which)
    ]
    several = [index for _, index, _, _ in every]
    logs = np.log(weights * prior.weights[several, None]) + np.array([log for _, _, log, _ in every])[:, None]
    both = [normal for _, _, _, normal in every]
    found = all_explained(both, prior.roots[several], prior.means[several], nuisance, sizes, logs)
    return [
        Explanation(misfit, index, under, normal, nuisance)
        for (misfit, index, _, normal), under in zip(every, found, strict=True)
    ]


def best_of(several: Sequence[Explanation]) -> tuple[Explanation, int]:
    """The most probable one, and the kind of drift under which it is."""
    best = max(several, key=lambda one: float(one.found.log_evidence.max()))
    return best, int(best.found.log_evidence.argmax())


def linear_rows(
    groups: Groups,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    prior: CalibrationPrior,
    measured: Measured = NOTHING_ELSE,
    told: Sequence[tuple[float, Normal]] | None = None,
) -> LinearRows:
    """Linear at θ.

    Args:
        told: what else is measured, as it told near another θ; default anew.
    """
    rows = groups.rows(chart, theta)
    jacobian = rows.jacobian[:, 0].T
    frames = [np.flatnonzero(groups.frame == frame) for frame in np.unique(groups.frame)]
    at_zero = rows.differences[0] - jacobian @ theta
    told = measured.told(chart, theta, prior) if told is None else told
    return LinearRows(groups, jacobian, at_zero, groups.deviation, frames, measured, told)
