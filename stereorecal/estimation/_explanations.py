"""θ under every prior and misfit that is compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior, drift_sizes
from stereorecal.estimation._evidence import Explained, Normal, all_explained, marginal
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._linear_groups import LinearGroups, correlation
from stereorecal.estimation._posterior import Posterior, merged, root

NOTHING = np.zeros((0, 0))
_LEAST = 1e-4  # of the weight of all explanations: below, one is dropped
_MOST = 32  # explanations: an estimate travels between processes


@cache
def _root_of_field() -> Float[np.ndarray, "p p"]:
    """Of its correlation, over all places."""
    return root(correlation(np.arange(PLACES[0] * PLACES[1])))


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


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What may be behind rows: the rig alone, or beside nuisance parameters.

    Attributes:
        rows: near its most probable θ; columns of nuisance parameters follow those of θ.
        several: θ under each misfit and prior that was compared; its probability is a part of their evidence. Left out
            where the hypothesis is kept to be asked of other rows.
        misfit: the most probable one.
        nuisance: a root of the covariance of those parameters.
        log_prior: logarithm of its probability before any image was seen.
    """

    rows: LinearGroups
    several: Sequence[Explanation]
    misfit: tuple[float, float]
    nuisance: Float[np.ndarray, "q q"]
    log_prior: float

    def explained(
        self, prior: CalibrationPrior, which: Sequence[int], rows: LinearGroups | None = None
    ) -> list[Explanation]:
        """θ under some covariances of the calibration's prior, by all of its rows or by some."""
        rows = self.rows if rows is None else rows
        misfit = self.misfit if len(rows.frames) > 1 else (float(np.hypot(*self.misfit)), 0.0)
        return explanations(rows, prior, which, [misfit], self.nuisance, self.log_prior)


def explanations(
    rows: LinearGroups,
    prior: CalibrationPrior,
    which: Sequence[int],
    misfits: Sequence[tuple[float, float]],
    nuisance: Float[np.ndarray, "q q"] = NOTHING,
    log_prior: float = 0.0,
) -> list[Explanation]:
    """θ for each misfit and some of the covariances of the calibration's prior, of rows whose last columns are nuisance
    parameters, of which `explained_by` tells."""
    whole = {misfit: rows.normal(misfit) for misfit in {of_a_frame for of_a_frame, _ in misfits}}
    normals = [with_common_field(rows, whole[of_a_frame], common) for of_a_frame, common in misfits]
    return explained_by(dict(zip(misfits, normals, strict=True)), rows.likelihoods, prior, which, nuisance, log_prior)


def with_common_field(rows: LinearGroups, whole: Normal, common: float) -> Normal:
    """A likelihood of `rows.normal` with the field integrated that all frames have in common, where there are several;
    `common` is the deviation of that field, pixels."""
    return marginal(whole, common * _root_of_field()) if len(rows.frames) > 1 else whole


def explained_by(
    normals: Mapping[tuple[float, float], Normal],
    likelihoods: Sequence[tuple[float, Normal]],
    prior: CalibrationPrior,
    which: Sequence[int],
    nuisance: Float[np.ndarray, "q q"] = NOTHING,
    log_prior: float = 0.0,
) -> list[Explanation]:
    """θ for each misfit, with what else may be told, under some of the covariances of the calibration's prior and all
    kinds of drift.

    Args:
        normals: the likelihood of rows under each misfit.
        likelihoods: as `Measured.likelihoods` has it; of nuisance parameters, too, or of θ alone.
        nuisance: a root of the covariance of what the likelihoods have besides θ.
        log_prior: logarithm of its probability.
    """
    sizes, weights = drift_sizes()
    every = [
        (misfit, index, log_told + log_prior, of_rows + of_others.with_nuisance(len(of_rows.b) - len(of_others.b)))
        for (misfit, of_rows), (log_told, of_others), index in product(normals.items(), likelihoods, which)
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


def evidence_of(several: Sequence[Explanation]) -> float:
    """Logarithm of the evidence of all together."""
    return float(np.logaddexp.reduce(np.concatenate([one.found.log_evidence for one in several])))


def mixture(several: Sequence[Explanation]) -> Posterior:
    """All explanations, each with its weight; what hardly weighs is left out, and what is alike is one."""
    evidence = np.stack([one.found.log_evidence for one in several])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    significant = np.argwhere(weights > _LEAST)
    some = weights[tuple(significant.T)]
    kinds = [(several[i].found, significant[significant[:, 0] == i, 1]) for i in np.unique(significant[:, 0])]
    means = np.concatenate([found.means[which] for found, which in kinds])
    covariances = np.concatenate([found.covariances(which) for found, which in kinds])
    return merged(Posterior(some / some.sum(), means, covariances), _MOST)
