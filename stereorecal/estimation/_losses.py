"""What a rig's errors cost: |epipolar error| over what a matcher notices and |error of depth| over a point, point by
point; and the rigs of least loss, which may be written.

Candidates are chosen by this loss, and judged by it. Errors are counted where images show something, and over the whole
view at some distances: rows that only corners would show, which nobody looks at, must not decide, and must not be lost.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import erf

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import InputError
from stereorecal.estimation._consequences import Consequences, Readings, consequences, nearness_of, within_lens
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.geometry import View, reread
from stereorecal.objectives import RigChart

_OF_SHOWN = 2.0 / 3.0  # of the weight of rows: where images show something; the rest is even over the view
_MOST_SHOWN = 250  # points that stand for what images show
_ROOT_2, _ROOT_2_PI = np.sqrt(2.0), np.sqrt(2.0 * np.pi)
_FINE, _LAST = 200, 8  # points a standard deviation, and how many of these
_ROUNDS, _SETTLED = 40, 0.02  # standard deviations of θ
_HALVINGS, _ROUNDING = 10, 1e-9
_FAR = 0.01  # of the loss, for a standard deviation from the posterior mean: what costs no loss stays likely
_KEPT = 0.5  # of the loss, for a change of depth by what matters, all ahead; four times as much for twice that change


@dataclass(frozen=True)
class Matters:
    """What counts as an error.

    Attributes:
        rows_px: of the epipolar error, as a matcher notices it, pixels.
        depth_points: of the error of depth, percentage points.
        distances: at which both count over the view, baselines.
    """

    rows_px: float = 0.05
    depth_points: float = 1.0
    distances: tuple[float, ...] = (5, 10, 30)


USUAL = Matters()


@dataclass(frozen=True, eq=False)
class Errors:
    """Epipolar errors and errors of depth of a rig at p points, in units of what matters: q = 2p errors.

    Attributes:
        readings: of the points even over the view at each of the distances that matter, and, if images show something,
            of a last set of points.
        matters: those units.
        shown: (m,) weights of the last set; empty: there is none.
    """

    readings: Readings
    matters: Matters
    shown: Float[np.ndarray, "m"]

    def of(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "q"]:
        """The errors of the rig at θ, if the one that is taken for true is: rows, then depth."""
        return self.readings.of(theta).ravel() / self._units

    @cached_property
    def slopes(self) -> Float[np.ndarray, "q n"]:
        """Slopes of rows, then of depth, by what the truth differs by, with the opposite sign."""
        near = self.readings.near
        return np.ascontiguousarray(np.concatenate([near.rows, near.nearness])) / self._units[:, None]

    @cached_property
    def _units(self) -> Float[np.ndarray, "q"]:
        return np.repeat([self.matters.rows_px, 0.01 * self.matters.depth_points], len(self.even))

    @cached_property
    def even(self) -> Float[np.ndarray, "p"]:
        """Weights of the points, even over the view and the distances."""
        return self._of_distances(0)

    @cached_property
    def seen(self) -> Float[np.ndarray, "p"]:
        """Weights of the points that the images show; even, where nobody knows."""
        if not len(self.shown):
            return self.even
        return np.concatenate([np.zeros(len(self.even) - len(self.shown)), self.shown])

    @cached_property
    def weights(self) -> Float[np.ndarray, "q"]:
        """The weights of all errors in the loss; those of rows sum to 1, and so do those of depth."""
        return np.concatenate([_OF_SHOWN * self.seen + (1.0 - _OF_SHOWN) * self.even, self.even])

    @cached_property
    def depth_ahead(self) -> Float[np.ndarray, "q"]:
        """Weights of depth alone, ahead: what is kept of depth. A rig that was turned bends depth by a tenth in the
        corners, and that need not be kept."""
        return np.concatenate([np.zeros_like(self.even), self._of_distances(1)])

    def _of_distances(self, which: int, distances: Sequence[float] | None = None) -> Float[np.ndarray, "p"]:
        """Weights of the points at some of the distances, default all, at each alike: over the view, 0, or ahead, 1."""
        near = self.readings.near
        some = near.distances if distances is None else distances
        counted = np.any([there for distance, there in near.at_distances if distance in some], axis=0)
        return near.weights[which] * counted / len(some)

    @cached_property
    def _of_losses(self) -> Float[np.ndarray, "q 4"]:
        """Weights of the errors in `Losses`, in their units."""
        none, matters = np.zeros_like(self.even), self.matters
        farthest = self._of_distances(1, [max(self.readings.near.distances)])
        rows = [np.concatenate([matters.rows_px * weights, none]) for weights in (self.seen, self.even)]
        return np.stack([*rows, np.concatenate([none, matters.depth_points * farthest]), self.weights], axis=1)

    def losses(self, found: Float[np.ndarray, "q"], samples: Float[np.ndarray, "s q"]) -> "Losses":
        """What a rig loses that has these errors, for errors of a rig without any under each sample."""
        away = found.astype(np.float32) - samples
        np.abs(away, out=away)  # in place: fresh pages for a few megabytes take longer than the sums
        lost = (away @ self._of_losses.astype(np.float32)).astype(float)
        lost.flags.writeable = False  # kept, and given to whoever asks again
        return Losses(*lost.T)


@dataclass(frozen=True, eq=False)
class Losses:
    """What a rig loses if each of s rigs drawn from the posterior is the true one.

    Attributes:
        seen: mean |epipolar error| where images show something, pixels.
        even: mean |epipolar error| over the whole view at all distances, pixels.
        farthest: mean |error of depth| ahead, in the middle half of the view each way, at the farthest distance,
            percent.
        total: the loss.
    """

    seen: Float[np.ndarray, "s"]
    even: Float[np.ndarray, "s"]
    farthest: Float[np.ndarray, "s"]
    total: Float[np.ndarray, "s"]


def errors_near(
    chart: RigChart,
    at: Float[np.ndarray, "n"],
    matters: Matters,
    view: View | None,
    shown: tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m"]] | None = None,
    slopes: Consequences | None = None,
) -> Errors:
    """Linear near the rig at θ = at, of points that stand for what the images show as well, if they and their weights
    are known; `slopes` are those of all these points near another rig, default this one."""
    points, weights = shown if shown is not None else (np.zeros((0, 3)), np.zeros(0))
    if slopes is None:
        slopes = consequences(chart, at, matters.distances, view, [points] if len(points) else [])
    return Errors(Readings(chart, at, view, slopes), matters, weights)


def extrinsics_like(chart: RigChart, view: View | None) -> Float[np.ndarray, "5 n"]:
    """The change of the extrinsics that is most like each parameter's in what it does to rows and depth."""
    errors = errors_near(chart, np.zeros(chart.dim), USUAL, view)
    slopes = np.sqrt(errors.weights)[:, None] * errors.slopes
    return np.linalg.lstsq(slopes[:, : len(DRIFTING)], slopes, rcond=None)[0]


def points_shown(
    groups: Groups, chart: RigChart, theta: Float[np.ndarray, "n"], view: View | None = None
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m"]]:
    """Points that groups show if the rig at θ is the true one, in the frame of its left camera, and their weights: each
    place of the image that shows something counts as much as another."""
    rig = chart.rig_at(theta)
    left, right = (rays / rays[:, 2:] for rays in (groups.left, groups.right))
    left = reread(left, chart.rig.left, rig.left)  # a yaw and a principal point that make up for each other
    right = reread(right, chart.rig.right, rig.right)  # would tell any depth, one without the other
    nearness = nearness_of(rig, left, right, view)
    some = np.flatnonzero((nearness > 0.0) & within_lens(rig.left, left) & within_lens(rig.right, right))
    some = np.random.default_rng(0).permutation(some)[:_MOST_SHOWN]  # groups are in the order of their depths
    nearness, left, groups = nearness[some], left[some], groups.of(some)
    of_place = np.bincount(groups.place, groups.count, int(np.prod(PLACES)))
    weights = groups.count / of_place[groups.place]
    depth = float(rig.baseline) / nearness
    return left * depth[:, None], weights / weights.sum()


@dataclass(frozen=True, eq=False)
class PointwiseLoss:
    """The expected loss of rigs, the true one drawn from a posterior, each error a mixture of k normal ones; and what a
    search makes least.

    Attributes:
        errors: near the posterior's mean.
        posterior: of θ.
    """

    errors: Errors
    posterior: Mixture

    @cached_property
    def centres(self) -> Float[np.ndarray, "k q"]:
        """Errors of a rig without any, for each of the normal distributions of the posterior."""
        return (self.posterior.means - self.errors.readings.at) @ self.errors.slopes.T

    @cached_property
    def deviations(self) -> Float[np.ndarray, "k q"]:
        """Deviations of the errors, likewise."""
        slopes = self.errors.slopes
        return np.sqrt(np.maximum(np.einsum("pi,kpi->kp", slopes, slopes @ self.posterior.covariances), 1e-18))

    @cached_property
    def spread(self) -> Float[np.ndarray, "n"]:
        """Standard deviations of θ."""
        return np.sqrt(np.maximum(np.diag(self.posterior.covariance), 1e-24))

    @cached_property
    def _far(self) -> Float[np.ndarray, "n n"]:
        """What is lost by the square of a distance from the mean."""
        scales = np.outer(self.spread, self.spread)
        correlations = self.posterior.covariance / scales + _ROUNDING * np.eye(len(scales))
        return _FAR * np.linalg.inv(correlations) / scales

    @cached_property
    def _initial(self) -> Float[np.ndarray, "q"]:
        """Errors of the initial rig, if that at the mean is true."""
        return self.errors.of(np.zeros_like(self.spread))

    def errors_at(self, theta: Float[np.ndarray, "n"], *, linear: bool) -> Float[np.ndarray, "q"]:
        """The errors of a rig, or, linear near the mean, of what need not be one."""
        return self.errors.slopes @ (theta - self.errors.readings.at) if linear else self.errors.of(theta)

    def searched(self, theta: Float[np.ndarray, "n"], found: Float[np.ndarray, "q"], keep_depth: float) -> float:
        """What is least where a search ends, as `least_loss` has it; `found` are the errors there."""
        away = theta - self.posterior.mean
        lost = self.expected(found) + float(away @ self._far @ away)
        if keep_depth:
            lost += _KEPT * keep_depth * float(self.errors.depth_ahead @ (found - self._initial) ** 2)
        return lost

    def searched_near(
        self, theta: Float[np.ndarray, "n"], found: Float[np.ndarray, "q"], keep_depth: float
    ) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
        """Curvature and slope of a quadratic bound of that, by θ."""
        slopes, (curvature, slope) = self.errors.slopes, self.quadratic(found)
        if keep_depth:
            kept = 2.0 * _KEPT * keep_depth * self.errors.depth_ahead
            curvature, slope = curvature + kept, slope + kept * (found - self._initial)
        by_theta = slopes.T @ (curvature[:, None] * slopes) + 2.0 * self._far
        return by_theta, slopes.T @ slope + 2.0 * self._far @ (theta - self.posterior.mean)

    def expected(self, found: Float[np.ndarray, "q"]) -> float:
        """The mean of |error|, that of a folded normal distribution at each point, for `errors.of` a rig."""
        z = (found - self.centres) / self.deviations
        density, twice = _normal(z)
        each = self.deviations * (2.0 * density + z * twice)
        return float(self.errors.weights @ (self.posterior.weights @ each))

    def quadratic(self, found: Float[np.ndarray, "q"]) -> tuple[Float[np.ndarray, "q"], Float[np.ndarray, "q"]]:
        """A bound from above that touches the loss at `found`: curvature and slope by each error (reweighted least
        squares; the curvature is slope over distance, as of any even loss)."""
        away = found - self.centres
        density, twice = _normal(away / self.deviations)
        flat = np.abs(away) < 1e-3 * self.deviations
        each = np.where(flat, 2.0 * density / self.deviations, twice / np.where(flat, 1.0, away))
        weights, probabilities = self.errors.weights, self.posterior.weights
        return weights * (probabilities @ each), weights * (probabilities @ twice)


def _normal(z: Float[np.ndarray, "*p"]) -> tuple[Float[np.ndarray, "*p"], Float[np.ndarray, "*p"]]:
    """The normal density, and twice the integral from 0: Taylor's series from the nearest point of a table, to 1e-11.
    SciPy, which has it, takes a seventh of a second to import."""
    points, densities, integrals = _table()
    size = np.fmin(np.abs(z), points[-1])  # of what is no number, the density is none
    near = np.rint(size * _FINE).astype(int)
    z0, h = points[near], size - points[near]
    integral = integrals[near] + densities[near] * h * (1.0 - h * (0.5 * z0 - h * (z0 * z0 - 1.0) / 6.0))
    return np.exp(-0.5 * z * z) / _ROOT_2_PI, np.copysign(2.0 * integral, z)


@cache
def _table() -> tuple[Float[np.ndarray, "p"], Float[np.ndarray, "p"], Float[np.ndarray, "p"]]:
    """Points, the normal density there, and its integral from 0."""
    points = np.arange(_LAST * _FINE + 1) / _FINE
    integrals = np.array([0.5 * erf(point / _ROOT_2) for point in points.tolist()])
    return points, np.exp(-0.5 * points**2) / _ROOT_2_PI, integrals


def least_loss(
    several: Sequence[PointwiseLoss],
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
        several: what rigs lose, with the same parameters.
        free: which parameters may change.
        shared: which are the same for all.
        keep_depth: times that a change of depth ahead, against the initial rig, costs its square: depth changes by
            little where rows need it, and by less where nothing does.
        linear: take errors as linear near the mean, where a rig need not stand; this saves most of the time.
    """
    own, common = np.flatnonzero(free & ~shared), np.flatnonzero(free & shared)
    # How parameters of each rig follow all unknowns, in standard deviations: its own, and last what is shared.
    follow = np.zeros((len(several), len(free), len(several) * len(own) + len(common)))
    for index, one in enumerate(several):
        follow[index, own, index * len(own) + np.arange(len(own))] = one.spread[own]
        follow[index, common, np.arange(-len(common), 0)] = several[0].spread[common]

    def at(thetas: Float[np.ndarray, "r n"]) -> tuple[float, list[Float[np.ndarray, "q"]]]:
        try:
            found = [one.errors_at(theta, linear=linear) for one, theta in zip(several, thetas, strict=True)]
        except InputError:  # no rig stands there
            return np.inf, []
        each = zip(several, thetas, found, strict=True)
        return sum(one.searched(theta, errors, keep_depth) for one, theta, errors in each), found

    means = np.stack([one.posterior.mean for one in several])
    thetas = np.where(free, np.where(shared, means[0], means), 0.0)
    loss, found = at(thetas)
    if not np.isfinite(loss):
        thetas = np.zeros_like(thetas)
        loss, found = at(thetas)
    for _ in range(_ROUNDS):
        each = zip(several, thetas, found, strict=True)
        bounds = [one.searched_near(theta, errors, keep_depth) for one, theta, errors in each]
        curvature = np.sum([to.T @ a @ to for to, (a, _) in zip(follow, bounds, strict=True)], axis=0)
        slope = np.sum([to.T @ b for to, (_, b) in zip(follow, bounds, strict=True)], axis=0)
        step = -np.linalg.solve(curvature, slope)
        for _ in range(_HALVINGS):
            moved = thetas + follow @ step
            lower, errors = at(moved)
            if lower <= loss:
                break
            step = 0.5 * step
        else:
            break
        thetas, loss, found = moved, lower, errors
        if np.abs(step).max(initial=0.0) < _SETTLED:
            break
    return list(thetas)
