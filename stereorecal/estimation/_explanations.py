"""θ under every prior and misfit that is compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._evidence import Explained, Normal, all_explained, marginal
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._linear_groups import LinearGroups
from stereorecal.estimation._misfit import correlation
from stereorecal.estimation._posterior import root

NOTHING = np.zeros((0, 0))


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


def explanations(
    rows: LinearGroups,
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
        normals = [marginal(whole[of_a_frame], common * _root_of_field()) for of_a_frame, common in misfits]
    else:
        normals = [whole[of_a_frame] for of_a_frame, _ in misfits]
    return explained_by(dict(zip(misfits, normals, strict=True)), rows.likelihoods, prior, which, nuisance, log_prior)


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
