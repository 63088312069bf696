"""Epipolar errors of groups, linear near a rig; what else is measured there; and the structured misfit of rows.

Misfit is what stays together in a region and is in no parameter of the rig. A moved thing, a shutter, a lens that the
model lacks: a field over the places of each frame, and one that all frames have in common. The evidence finds their
deviations; their length is short, since a smooth field would be the keystone of a yaw.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, reduce
from itertools import product
from operator import add
from statistics import NormalDist

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.estimation._evidence import ALONE, Normal, Nuisances, integrated, marginal, normal_of
from stereorecal.estimation._groups import FEWEST_GROUPS, PLACES, Groups, grouped
from stereorecal.estimation._matched_ranges import NO_RANGES, MatchedRanges
from stereorecal.estimation._mixture import Mixture, Travels, remembered, root
from stereorecal.estimation._motion import NO_WINDOWS, Windows
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.objectives import RigChart
from stereorecal.scoring import Correspondences

DEVIATIONS = (0.0, 0.02, 0.04, 0.07, 0.12, 0.2, 0.4, 0.8)  # pixels, of the field of a frame
COMMON = (0.0, 0.02, 0.04, 0.07, 0.12, 0.2)  # pixels, of the field that all frames have in common
USUAL = 0.07  # pixels, of the field of a frame: that of most good pairs, or more
_LENGTH = 1.5  # places
_ROUNDING = 1e-10  # of the field's variance
_ROUNDS, _REDESCENDS = 5, 1.5  # of the fit of one pair; robust deviations
_BOUND = 3.0  # standard deviations: beyond, a group that errs alone counts for less (Cauchy)
_CHANCE = 1e-3  # that a frame of the same rig is taken for one of another
_OWN = np.array([0.5, 0.5, 0.5, 0.5, 0.5])  # degrees and percent: how far the rig may have moved between frames
ROWS_MATTER = 0.1  # pixels: frames that differ by less agree well enough


def neighbours(value: float, grid: tuple[float, ...]) -> tuple[float, ...]:
    """A value of a grid, and those beside it."""
    at = grid.index(value)
    return grid[max(at - 1, 0) : at + 2]


def correlation(place: Int[np.ndarray, "g"]) -> Float[np.ndarray, "g g"]:
    """The correlation of the field at places."""
    return _correlation_of_places()[np.ix_(place, place)]


@cache
def _correlation_of_places() -> Float[np.ndarray, "p p"]:
    """The correlation of all places."""
    row, column = np.divmod(np.arange(PLACES[0] * PLACES[1]), PLACES[0])
    apart2 = (row[:, None] - row) ** 2 + (column[:, None] - column) ** 2
    return np.exp(-0.5 * apart2 / _LENGTH**2)


@cache
def _root_of_field() -> Float[np.ndarray, "p p"]:
    """A root of the field's correlation over all places."""
    return root(_correlation_of_places())


def covariance_of_rows(
    place: Int[np.ndarray, "g"], deviation: Float[np.ndarray, "g"], misfit: float
) -> Float[np.ndarray, "g g"]:
    """The covariance of the mean row differences of the groups of one frame, with a misfit of this deviation."""
    return misfit**2 * correlation(place) + np.diag(deviation**2)


def unexpected(covariance: Float[np.ndarray, "g g"], residual: Float[np.ndarray, "g"]) -> Float[np.ndarray, "g"]:
    """Residuals of groups against what all others of their frame let expect of them, in standard deviations: large
    where one group errs alone, small in a region that moved as a whole."""
    precision = np.linalg.inv(covariance)
    return precision @ residual / np.sqrt(np.diag(precision))


@dataclass(frozen=True, eq=False)
class Model:
    """What is known of a rig besides rows.

    Attributes:
        chart: from θ to rigs.
        prior: of what the calibration left.
        ranges, windows: of what was seen.
    """

    chart: RigChart
    prior: Mixture
    ranges: MatchedRanges = NO_RANGES
    windows: Windows = NO_WINDOWS

    def likelihoods(self, theta: Float[np.ndarray, "n"]) -> list[tuple[float, Normal]]:
        """What ranges and windows may tell of θ, near a θ: every combination, each with the logarithm of its
        probability."""
        of_ranges = self.ranges.likelihoods(self.chart, theta)
        of_windows = self.windows.likelihoods(self.chart, theta, self.prior)
        return [(one + other, a + b) for (one, a), (other, b) in product(of_ranges, of_windows)]

    def linear(
        self, groups: Groups, theta: Float[np.ndarray, "n"], likelihoods: Sequence[tuple[float, Normal]] | None = None
    ) -> "LinearGroups":
        """The rows of groups, linear near θ; with likelihoods of ranges and windows as they were near another θ, or
        anew."""
        rows, jacobian = groups.rows(self.chart, theta)
        likelihoods = self.likelihoods(theta) if likelihoods is None else likelihoods
        return LinearGroups(self, groups, jacobian, rows - jacobian @ theta, groups.deviation, likelihoods)


@dataclass(frozen=True, eq=False)
class LinearGroups(Travels):
    """The rows of groups near θ: r₀ + J θ.

    Attributes:
        model: what is known besides.
        groups: with frames, places and deviations.
        jacobian: (g, n + q); nuisance parameters may follow θ.
        at_zero: (g,) r₀.
        deviation: (g,) pixels; larger than that of `groups` where a group errs alone.
        likelihoods: what else may tell of θ, as `Model.likelihoods` has it.
        nuisances: what follows θ.
    """

    model: Model
    groups: Groups
    jacobian: Float[np.ndarray, "g n"]
    at_zero: Float[np.ndarray, "g"]
    deviation: Float[np.ndarray, "g"]
    likelihoods: Sequence[tuple[float, Normal]]
    nuisances: Nuisances = ALONE

    @cached_property
    def frames(self) -> list[Int[np.ndarray, "_"]]:
        """Indices of the groups of each frame."""
        return [np.flatnonzero(self.groups.frame == frame) for frame in np.unique(self.groups.frame)]

    def of(self, which: Bool[np.ndarray, "g"]) -> "LinearGroups":
        """Some of them."""
        some = {name: getattr(self, name)[which] for name in ("jacobian", "at_zero", "deviation")}
        return replace(self, groups=self.groups.of(which), **some)

    def beside(self, nuisances: Nuisances, columns: Float[np.ndarray, "g q"]) -> "LinearGroups":
        """The same with nuisance parameters after θ, which do this to rows."""
        return replace(self, jacobian=np.column_stack([self.jacobian, columns]), nuisances=nuisances)

    def residual(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "g"]:
        """The rows at θ."""
        return self.at_zero + self.jacobian @ theta

    @remembered
    def normal(self, misfit: tuple[float, float]) -> Normal:
        """The likelihood of θ under a misfit: deviations of the field of each frame, and of the one that all have in
        common."""
        own, common = misfit
        if common:
            return marginal(self.beside_places.normal((own, 0.0)), common * _root_of_field())
        each = (integrated(alone, own * cross, own**2 * field) for alone, cross, field in self._of_frames)
        return reduce(add, each)

    @cached_property
    def beside_places(self) -> "LinearGroups":
        """The same with an offset of each place after what they have: a field that frames have in common, or what
        moved."""
        places = np.eye(PLACES[0] * PLACES[1])[self.groups.place]
        return replace(self, jacobian=np.column_stack([self.jacobian, places]))

    @cached_property
    def _of_frames(self) -> list[tuple[Normal, Float[np.ndarray, "_ m"], Float[np.ndarray, "_ _"]]]:
        """What `integrated` takes for each frame: its own field, were that 1 large, over the places at which it shows
        something."""
        found = []
        for f in self.frames:
            places, place = np.unique(self.groups.place[f], return_inverse=True)
            weights = np.zeros((len(places), len(f)))
            weights[place, np.arange(len(f))] = self.deviation[f] ** -2.0
            field = np.linalg.cholesky(correlation(places) + _ROUNDING * np.eye(len(places)))
            alone = normal_of(self.jacobian[f], self.at_zero[f], self.deviation[f])
            cross = field.T @ (weights @ np.column_stack([self.jacobian[f], -self.at_zero[f]]))
            found.append((alone, cross, (field.T * weights.sum(axis=1)) @ field))
        return found

    def robust(self, misfit: float, theta: Float[np.ndarray, "n"]) -> "LinearGroups":
        """The same with the deviations that groups should have, if those that err alone at θ have a bounded say."""
        unexpected_errors, residual = np.zeros(len(self.at_zero)), self.residual(theta)
        for f in self.frames:
            covariance = covariance_of_rows(self.groups.place[f], self.groups.deviation[f], misfit)
            unexpected_errors[f] = unexpected(covariance, residual[f])
        deviation = self.groups.deviation * np.sqrt(1.0 + (unexpected_errors / _BOUND) ** 2)
        return replace(self, deviation=deviation)


def rows_of_groups(
    groups: Groups, chart: RigChart, z: Float[np.ndarray, "n"]
) -> tuple[Float[np.ndarray, "g"], Float[np.ndarray, "g n"], Float[np.ndarray, "g"]]:
    """The mean row differences of groups at a point of a chart, pixels of the images, their derivatives, and the weight
    of each one's square, 1 / pixels²: what a search fits between matches, where nothing is asked of misfit and
    nuisances."""
    (rows, jacobian), deviation = groups.rows(chart, z), np.hypot(groups.deviation, USUAL)
    deviation = deviation * _farther(groups, rows / deviation)  # larger while far off
    share = groups.count / groups.count.mean()
    return rows, jacobian, share / (deviation**2 + (rows / _BOUND) ** 2)


def _farther(groups: Groups, away: Float[np.ndarray, "g"]) -> float:
    """How many times farther off than expected correspondences are, in the middle; at least as far as expected."""
    return max(1.0, 1.4826 * float(np.median(np.repeat(np.abs(away), groups.count))))


def normal_of_pair(
    found: Correspondences,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    mean: Float[np.ndarray, "n"],
    covariance: Float[np.ndarray, "n n"],
) -> tuple[Normal, Float[np.ndarray, "n"]] | None:
    """What one pair says of θ, linear near a θ that is not far off; and the most probable θ after it. None, if there
    are too few groups.

    Args:
        mean, covariance: of θ before, by which it is told what has no say.

    Of each pair a robust fit (iterated reweighting; Holland & Welsch 1977): what moved has no say in the end. Nothing
    is asked of misfit and nuisances, which are the next pair's as well or none of its.
    """
    groups = grouped(found, chart, theta)
    if len(groups) < FEWEST_GROUPS:
        return None
    (rows, jacobian), deviation = groups.rows(chart, theta), np.hypot(groups.deviation, USUAL)
    at_zero, theta = rows - jacobian @ theta, mean
    a, b = np.zeros((chart.dim, chart.dim)), np.zeros(chart.dim)
    for _ in range(_ROUNDS):
        away = (at_zero + jacobian @ theta) / deviation
        scale = _farther(groups, away)
        weighted = jacobian.T * np.exp(-0.5 * (away / (_REDESCENDS * scale)) ** 2) / (scale * deviation) ** 2
        a, b = weighted @ jacobian, -weighted @ at_zero
        theta = mean + np.linalg.solve(np.eye(len(b)) + covariance @ a, covariance @ (b - a @ mean))
    return Normal(a, b, 0.0), theta


@dataclass(frozen=True)
class OtherRig:
    """A frame that shows another rig than the others.

    Attributes:
        frame: its number.
        rows_px: root mean square of the rows by which its own rig differs.
    """

    frame: int
    rows_px: float


def other_rigs(rows: LinearGroups, misfit: float, theta: Float[np.ndarray, "n"]) -> tuple[OtherRig, ...]:
    """The frames that would be far more probable with extrinsics of their own, by rows that matter; the farthest first.
    The misfit is the deviation of the field of each frame, pixels; θ is the solution of all."""
    if len(rows.frames) < 2:
        return ()
    own, limit = len(DRIFTING), _chi_square(len(DRIFTING), 1.0 - _CHANCE / len(rows.frames))
    residual, found = rows.residual(theta), []
    for f in rows.frames:
        precision = np.linalg.inv(covariance_of_rows(rows.groups.place[f], rows.deviation[f], misfit))
        slopes = rows.jacobian[f, :own]
        pull = slopes.T @ precision @ residual[f]
        move = np.linalg.solve(slopes.T @ precision @ slopes + np.diag(_OWN**-2.0), pull)
        rows_px = float(np.sqrt(np.mean((slopes @ move) ** 2)))
        if float(pull @ move) > limit and rows_px > ROWS_MATTER:
            found.append(OtherRig(int(rows.groups.frame[f[0]]), rows_px))
    return tuple(sorted(found, key=lambda one: -one.rows_px))


def _chi_square(degrees: int, probability: float) -> float:
    """A quantile, by the cube root of Wilson & Hilferty (1931)."""
    tenth = 2.0 / (9.0 * degrees)
    return degrees * (1.0 - tenth + NormalDist().inv_cdf(probability) * np.sqrt(tenth)) ** 3
