"""What is known of θ under each kind of calibration: the filter takes all kinds as one normal distribution, and what it
has learnt of the lenses, which do not drift, tells them apart.

A calibration is as good as its boards were seen, which nobody says: the prior of an estimate is a mixture of kinds. A
filter of each kind would differ in nothing but where it began; the likelihood of the lenses after all looks is the
posterior over what it began with, and begins anew with each kind.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Mixture, as_prior, is_exact, rig_parameters, root
from stereorecal.geometry import StereoRig
from stereorecal.objectives import EXTRINSICS
from stereorecal.online._filter import DRIFT, SIZE, FilterEstimate

_YAW = EXTRINSICS.index("yaw")
_WIDER = 2.0  # as wide as nearly all of the kinds
_NOTHING = 1e-9  # of a variance: a direction in which no kind differs


@lru_cache(maxsize=4)  # a step asks several times
def posterior(initial: StereoRig, prior: str | None, filtered: FilterEstimate) -> Mixture:
    """The posterior of θ, one normal distribution: that of the mixture of all kinds, by their evidence."""
    mean, covariance = filtered.theta, filtered.of_theta
    if is_exact(prior):
        return Mixture.single(mean, covariance)
    weights, informations, log_volumes = _kinds(initial, prior)
    ways = np.eye(len(mean)) + covariance @ informations
    covariances = np.linalg.solve(ways, np.broadcast_to(covariance, informations.shape))
    pulls = -informations @ mean
    moves = np.einsum("kij,kj->ki", covariances, pulls)
    logs = np.log(weights) - 0.5 * (log_volumes + np.linalg.slogdet(ways)[1] - np.sum(pulls * (mean + moves), 1))
    every = Mixture(np.exp(logs - np.logaddexp.reduce(logs)), mean + moves, covariances)
    return Mixture.single(every.mean, every.covariance)


def before_looks(initial: StereoRig, prior: str | None, *, any_yaw: bool = False) -> Float[np.ndarray, "n n"]:
    """The covariance of θ before the first look: what a calibration leaves, and a drift; but none of yaw, unless
    intrinsics are exact, or it is said: the rig was calibrated, so that something will show a yaw that it has turned
    by, and intrinsics that are wrong bend rows as a yaw does, which is none."""
    calibration = _calibration_root(initial, prior)
    drift = np.pad(DRIFT, (0, len(calibration) - SIZE))
    if not (any_yaw or is_exact(prior)):
        drift[_YAW] = 0.0
    return calibration @ calibration.T + np.diag(drift**2)


def squared_error(initial: StereoRig, prior: str | None, filtered: FilterEstimate) -> float:
    """How far the lenses are off, in squared standard deviations that calibrations leave."""
    root = _calibration_root(initial, prior)[SIZE:]
    return float(np.sum((np.linalg.pinv(root) @ filtered.theta[SIZE:]) ** 2))


@lru_cache(maxsize=2)
def _calibration_root(initial: StereoRig, prior: str | None) -> Float[np.ndarray, "n n"]:
    """A root of the covariance of what a calibration leaves of θ, of all kinds, but wider: the filter begins with it,
    and kinds, each of which knows more, are told apart later."""
    known = as_prior(prior, rig_parameters(initial))
    return _WIDER * root(np.einsum("k,kij,klj->il", known.weights, known.roots, known.roots))


@lru_cache(maxsize=2)
def _kinds(
    initial: StereoRig, prior: str | None
) -> tuple[Float[np.ndarray, "k"], Float[np.ndarray, "k n n"], Float[np.ndarray, "k"]]:
    """The probability of each kind; what it knows of the lenses more than all kinds together, as information of θ; and
    the logarithm of its volume, of theirs. Where it knows less, it is as they are."""
    known, lenses = as_prior(prior, rig_parameters(initial)), slice(SIZE, None)
    white = np.linalg.pinv(_calibration_root(initial, prior)[lenses])
    of_kinds = white @ known.roots[:, lenses]
    values, axes = np.linalg.eigh(of_kinds @ of_kinds.swapaxes(1, 2))
    values = np.where(values > _NOTHING, np.minimum(values, 1.0), 1.0)
    axes = white.T @ axes
    informations = np.zeros_like(known.roots)
    informations[:, lenses, lenses] = (axes * (1.0 / values - 1.0)[:, None]) @ axes.swapaxes(1, 2)
    return known.weights, informations, np.log(values).sum(axis=1)
