"""Rigs that may be written: the one of least expected loss, and the one of least loss to which a change of depth costs
its square."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import InputError
from stereorecal.estimation._losses import Errors, PointwiseLoss
from stereorecal.estimation._posterior import Posterior, merged

_ROUNDS, _SETTLED = 40, 0.02  # standard deviations of θ
_HALVINGS, _ROUNDING = 10, 1e-9
_FAR = 0.01  # of the loss, for a standard deviation from the posterior mean: what costs no loss stays likely
_NORMALS = 8  # of a posterior: so many hold what its loss depends on
_KEPT = 0.5  # of the loss, for a change of depth by what matters, all ahead; four times as much for twice that change


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a rig, as far as candidates are chosen by it.

    Attributes:
        errors: of rigs near the posterior's mean.
        posterior: of θ.
        initial: errors of the initial rig, if that at the mean is true.
    """

    errors: Errors
    posterior: Posterior
    initial: Float[np.ndarray, "q"]

    @property
    def deviations(self) -> Float[np.ndarray, "n"]:
        """Of θ."""
        return np.sqrt(np.maximum(np.diag(self.posterior.covariance), 1e-24))


def least_loss(
    several: Sequence[Known],
    free: Bool[np.ndarray, "n"],
    shared: Bool[np.ndarray, "n"],
    *,
    keep_depth: float = 0.0,
    linear: bool = False,
) -> list[Float[np.ndarray, "n"]]:
    """θ of each rig, which together lose least, of those whose held parameters are as given (0); 0, if no rigs stand
    there.

    Reweighted least squares: the pointwise loss is convex, and a quadratic bound of it falls with each step.

    Args:
        several: rigs, with the same parameters.
        free: which parameters may change.
        shared: which are the same for all.
        keep_depth: times that a change of depth ahead, against the initial rig, costs its square: depth changes by
            little where rows need it, and by less where nothing does.
        linear: take errors as linear near the mean, where a rig need not stand; this spares most of the time.
    """
    searches = [_Search(one, keep_depth, linear) for one in several]
    units = [np.where(shared, several[0].deviations, one.deviations) for one in several]
    own, common = np.flatnonzero(free & ~shared), np.flatnonzero(free & shared)
    moves, size = np.concatenate([own, common]), len(several) * len(own) + len(common)
    where = [
        np.r_[index * len(own) : (index + 1) * len(own), size - len(common) : size] for index in range(len(several))
    ]

    def at(thetas: list[Float[np.ndarray, "n"]]) -> tuple[float, list[Float[np.ndarray, "q"]]]:
        try:
            found = [one.errors_at(theta) for one, theta in zip(searches, thetas, strict=True)]
        except InputError:  # no rig stands there
            return np.inf, []
        return sum(one.loss_at(theta, of) for one, theta, of in zip(searches, thetas, found, strict=True)), found

    thetas = [np.where(free, np.where(shared, several[0].posterior.mean, one.posterior.mean), 0.0) for one in several]
    loss, found = at(thetas)
    if not np.isfinite(loss):
        thetas = [np.zeros_like(theta) for theta in thetas]
        loss, found = at(thetas)
    for _ in range(_ROUNDS):
        curvature, slope = np.zeros((size, size)), np.zeros(size)
        for search, theta, of_rig, unit, own_and_common in zip(searches, thetas, found, units, where, strict=True):
            a, b = search.quadratic(theta, of_rig)
            scale = unit[moves]
            curvature[np.ix_(own_and_common, own_and_common)] += scale[:, None] * a[np.ix_(moves, moves)] * scale
            slope[own_and_common] += scale * b[moves]
        step = -np.linalg.solve(curvature, slope)
        for _ in range(_HALVINGS):
            moved = [theta.copy() for theta in thetas]
            for theta, unit, own_and_common in zip(moved, units, where, strict=True):
                theta[moves] += unit[moves] * step[own_and_common]
            lower, errors = at(moved)
            if lower <= loss:
                break
            step = 0.5 * step
        else:
            break
        thetas, loss, found = moved, lower, errors
        if np.abs(step).max(initial=0.0) < _SETTLED:
            break
    return thetas


class _Search:
    """One rig's part of the loss."""

    def __init__(self, known: Known, keep_depth: float, linear: bool) -> None:
        posterior = merged(known.posterior, 1 if linear else _NORMALS)
        self.known, self.kept, self.linear = known, _KEPT * keep_depth, linear
        self.loss = PointwiseLoss.under(known.errors, posterior)
        scale = known.deviations
        self.far = _FAR * np.linalg.inv(
            known.posterior.covariance / np.outer(scale, scale) + _ROUNDING * np.eye(len(scale))
        )
        self.far /= np.outer(scale, scale)

    def errors_at(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "q"]:
        errors = self.known.errors
        return errors.slopes @ (theta - errors.at) if self.linear else errors.of(theta)

    def loss_at(self, theta: Float[np.ndarray, "n"], found: Float[np.ndarray, "q"]) -> float:
        """What is minimised."""
        away = theta - self.known.posterior.mean
        loss = self.loss.expected(found) + float(away @ self.far @ away)
        if self.kept:
            loss += self.kept * float(self.known.errors.depth_ahead @ (found - self.known.initial) ** 2)
        return loss

    def quadratic(
        self, theta: Float[np.ndarray, "n"], found: Float[np.ndarray, "q"]
    ) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
        """Curvature and slope of a bound, by θ."""
        slopes = self.known.errors.slopes
        curvature, slope = self.loss.quadratic(found)
        if self.kept:
            kept = 2.0 * self.kept * self.known.errors.depth_ahead
            curvature, slope = curvature + kept, slope + kept * (found - self.known.initial)
        by_theta = slopes.T @ (curvature[:, None] * slopes) + 2.0 * self.far
        return by_theta, slopes.T @ slope + 2.0 * self.far @ (theta - self.known.posterior.mean)
