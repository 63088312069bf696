"""Between a posterior and priors of rigs: what is known does not change, but the rig that it is counted from."""

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior, calibration_prior
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._posterior import Posterior, root
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.objectives import RigChart

_YAW_UNKNOWN = 1.0  # degrees: what a repair that takes the intrinsics as exact may leave, which is all of depth


def recentred_posterior(posterior: Posterior, used: Float[np.ndarray, "n"]) -> Posterior:
    """What a posterior says of changes from the rig at θ = used: one normal distribution, since six hold the truth no
    more often (two repairs in turn of 180 simulated rigs)."""
    covariance = 0.5 * (posterior.covariance + posterior.covariance.T)
    return Posterior(np.ones(1), (posterior.mean - used)[None], covariance[None])


def as_prior_of(known: Posterior) -> CalibrationPrior:
    """A posterior as a prior."""
    roots = np.stack([root(covariance) for covariance in known.covariances])
    return CalibrationPrior(roots, known.weights, means=known.means)


def as_mixture(prior: CalibrationPrior) -> Posterior:
    """A prior as a mixture of normal distributions."""
    covariances = prior.roots @ prior.roots.swapaxes(1, 2)
    return Posterior(prior.weights, prior.means, 0.5 * (covariances + covariances.swapaxes(1, 2)))


def recentred_prior(prior: CalibrationPrior, used: Float[np.ndarray, "n"]) -> CalibrationPrior:
    """The same of changes from the rig at θ = used."""
    return CalibrationPrior(prior.roots, prior.weights, means=prior.means - used)


def prior_without_depth(chart: RigChart) -> CalibrationPrior:
    """Of a rig that was repaired, and nobody knows how well: with a yaw that may be off by any amount that is left."""
    yaw = DRIFTING.index("yaw")
    loose, prior = np.zeros((chart.dim, chart.dim)), calibration_prior(chart)
    loose[yaw, yaw] = _YAW_UNKNOWN**2
    roots = np.stack([root(one @ one.T + loose) for one in prior.roots])
    return CalibrationPrior(roots, prior.weights, means=prior.means)


def updated(prior: CalibrationPrior, normal: Normal) -> CalibrationPrior:
    """Each normal distribution given the likelihood, weighed by its evidence."""
    roots, means, logs = [], [], []
    for one, mean, weight in zip(prior.roots, prior.means, prior.weights, strict=True):
        around = normal.around(mean)
        lower = np.linalg.cholesky(np.eye(len(mean)) + one.T @ around.a @ one)
        pull = np.linalg.solve(lower, one.T @ around.b)
        after = np.linalg.solve(lower, one.T).T
        roots.append(after)
        means.append(mean + after @ pull)
        logs.append(np.log(weight) - 0.5 * (around.c - pull @ pull) - np.log(np.diag(lower)).sum())
    weights = np.exp(np.array(logs) - np.logaddexp.reduce(logs))
    return CalibrationPrior(np.stack(roots), weights, means=np.stack(means))
