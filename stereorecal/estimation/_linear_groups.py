"""Row errors of groups, linear near a rig."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._evidence import Normal, normal_of
from stereorecal.estimation._groups import FEWEST_GROUPS, PLACES, Groups, grouped
from stereorecal.estimation._measured import Measured
from stereorecal.estimation._misfit import USUAL, covariance_of_rows, unexpected
from stereorecal.objectives import LinearRows, RigChart
from stereorecal.scoring import Correspondences

_BOUND = 3.0  # standard deviations: beyond, a group that errs alone counts for less (Cauchy)


@dataclass(frozen=True, eq=False)
class LinearGroups:
    """The rows of groups near θ: r₀ + J θ.

    Attributes:
        groups: with frames, places and deviations.
        jacobian: (g, n); nuisance parameters may follow θ.
        at_zero: (g,) r₀.
        deviation: (g,) pixels; larger than that of `groups` where a group errs alone.
        frames: indices of the groups of each frame.
        measured: ranges and windows.
        likelihoods: what these may tell of θ, as `Measured.likelihoods` has it.
    """

    groups: Groups
    jacobian: Float[np.ndarray, "g n"]
    at_zero: Float[np.ndarray, "g"]
    deviation: Float[np.ndarray, "g"]
    frames: Sequence[Int[np.ndarray, "_"]]
    measured: Measured
    likelihoods: Sequence[tuple[float, Normal]]

    def of(self, which: Bool[np.ndarray, "g"]) -> "LinearGroups":
        """Some of them."""
        groups = self.groups.of(which)
        return replace(
            self,
            groups=groups,
            jacobian=self.jacobian[which],
            at_zero=self.at_zero[which],
            deviation=self.deviation[which],
            frames=_frames(groups),
        )

    def with_columns(self, columns: Float[np.ndarray, "g q"]) -> "LinearGroups":
        """With nuisance parameters after θ, which do this to rows."""
        return replace(self, jacobian=np.column_stack([self.jacobian, columns]))

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
        unexpected_errors, residual = np.zeros(len(self.at_zero)), self.residual(theta)
        for f in self.frames:
            covariance = covariance_of_rows(self.groups.place[f], self.groups.deviation[f], misfit)
            unexpected_errors[f] = unexpected(covariance, residual[f])
        return self.groups.deviation * np.sqrt(1.0 + (unexpected_errors / _BOUND) ** 2)


def linear_groups(
    groups: Groups,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    prior: CalibrationPrior,
    measured: Measured,
    likelihoods: Sequence[tuple[float, Normal]] | None = None,
) -> LinearGroups:
    """The rows of groups, linear near θ.

    Args:
        likelihoods: of ranges and windows, as they were near another θ; default anew.
    """
    rows = groups.rows(chart, theta)
    jacobian = rows.jacobian[:, 0].T
    at_zero = rows.differences[0] - jacobian @ theta
    likelihoods = measured.likelihoods(chart, theta, prior) if likelihoods is None else likelihoods
    return LinearGroups(groups, jacobian, at_zero, groups.deviation, _frames(groups), measured, likelihoods)


def _frames(groups: Groups) -> list[Int[np.ndarray, "_"]]:
    """Indices of the groups of each frame."""
    return [np.flatnonzero(groups.frame == frame) for frame in np.unique(groups.frame)]


def rows_of_groups(
    found: Correspondences, chart: RigChart, z: Float[np.ndarray, "n"]
) -> tuple[LinearRows, Float[np.ndarray, "1 g"]] | None:
    """The mean row differences of groups near a point of a chart, pixels of the images, and the weight of each one's
    square, 1 / pixels²: what a search fits between matches, where nothing is asked of misfit and nuisances; None, if
    there are too few groups."""
    groups = grouped(found, chart, z)
    if len(groups) < FEWEST_GROUPS:
        return None
    rows, deviation = groups.rows(chart, z), np.hypot(groups.deviation, USUAL)
    away = np.repeat(np.abs(rows.differences[0] / deviation), groups.count)
    deviation = deviation * max(1.0, 1.4826 * float(np.median(away)))  # larger while far off
    share = groups.count / groups.count.mean()
    return rows, share / (deviation**2 + (rows.differences / _BOUND) ** 2)
