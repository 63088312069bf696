"""θ under every prior and misfit that is compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from stereorecal.estimation._calibration_prior import drift_sizes
from stereorecal.estimation._evidence import ALONE, Explanation, Normal, Nuisances, all_explained
from stereorecal.estimation._linear_groups import COMMON, DEVIATIONS, LinearGroups, Model, neighbours
from stereorecal.estimation._mixture import Mixture, merged

NEGLIGIBLE = 12.0  # nats below the best: what has no say
_LEAST = 1e-4  # of the weight of all explanations: below, one is dropped
_MOST = 32  # explanations: an estimate travels between processes


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What may be behind rows: the rig alone, or beside nuisance parameters.

    Attributes:
        rows: near its most probable θ; columns of nuisance parameters follow those of θ.
        several: θ under each misfit and prior that was compared; its probability is a part of their evidence. Left
            out of what is `kept`.
        misfit: the most probable one.
    """

    rows: LinearGroups
    several: Sequence[Explanation]
    misfit: tuple[float, float]

    @classmethod
    def of(cls, rows: LinearGroups, several: Sequence[Explanation]) -> "Hypothesis":
        """What was compared."""
        return cls(rows, several, best_of(several).misfit)

    @property
    def kept(self) -> "Hypothesis":
        """The same, to be asked of other rows; what is derived stays behind."""
        return replace(self, rows=replace(self.rows), several=())

    def explained(self, rows: LinearGroups) -> list[Explanation]:
        """θ by some of its rows, under all covariances: the others may have told against one that these ask for."""
        misfit = self.misfit if len(rows.frames) > 1 else (float(np.hypot(*self.misfit)), 0.0)
        return explanations(rows, range(len(rows.model.prior.roots)), [misfit])


def hypothesis_near(rows: LinearGroups, misfit: tuple[float, float]) -> Hypothesis:
    """θ under a misfit and all of the calibration's covariances, and under the misfits beside it where these have a
    say."""
    found = explanations(rows, range(len(rows.model.prior.roots)), [misfit])
    common = neighbours(misfit[1], COMMON) if len(rows.frames) > 1 else (misfit[1],)
    beside = [one for one in product(neighbours(misfit[0], DEVIATIONS), common) if one != misfit]
    least = best_of(found).most - NEGLIGIBLE
    with_a_say = sorted({one.prior for one in found if one.most > least})
    return Hypothesis.of(rows, found + explanations(rows, with_a_say, beside))


def explanations(rows: LinearGroups, which: Sequence[int], misfits: Sequence[tuple[float, float]]) -> list[Explanation]:
    """θ and the nuisance parameters of rows for each misfit and some of the covariances of the calibration's prior."""
    normals = {misfit: rows.normal(misfit) for misfit in misfits}
    return explained_by(rows.model, normals, rows.likelihoods, which, rows.nuisances)


def explained_by(
    model: Model,
    normals: Mapping[tuple[float, float], Normal],
    likelihoods: Sequence[tuple[float, Normal]],
    which: Sequence[int],
    nuisances: Nuisances = ALONE,
) -> list[Explanation]:
    """θ for each misfit, with what else may be told, under some of the covariances of the calibration's prior and all
    kinds of drift.

    Args:
        normals: the likelihood of rows under each misfit, of θ and nuisance parameters.
        likelihoods: as `Model.likelihoods` has it; of nuisance parameters, too, or of θ alone.
    """
    told = [
        (misfit, log + nuisances.log_prior, of_rows + others.with_nuisance(len(of_rows.b) - len(others.b)))
        for (misfit, of_rows), (log, others) in product(normals.items(), likelihoods)
    ]
    return all_explained(told, which, model.prior, nuisances, drift_sizes())


def best_of(several: Sequence[Explanation]) -> Explanation:
    """The most probable one."""
    return max(several, key=lambda one: one.most)


def evidence_of(several: Sequence[Explanation]) -> float:
    """Logarithm of the evidence of all together."""
    return float(np.logaddexp.reduce(np.concatenate([one.log_evidence for one in several])))


def mixture(several: Sequence[Explanation], most: int = _MOST) -> Mixture:
    """All explanations, each with its weight, so many at most; what hardly weighs is left out, and what is alike is
    one."""
    evidence = np.stack([one.log_evidence for one in several])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    significant = np.argwhere(weights > _LEAST)
    some = weights[tuple(significant.T)]
    kinds = [(several[i], significant[significant[:, 0] == i, 1]) for i in np.unique(significant[:, 0])]
    means = np.concatenate([one.means[which] for one, which in kinds])
    covariances = np.concatenate([one.covariances(which) for one, which in kinds])
    return merged(Mixture(some / some.sum(), means, covariances), most)
