"""One look at one pair through the calibration in use, at half scale: what it measures, and how well; and which parts
of the view, at which distances, its matches cover.

Everything rests on one linearisation at the solution, cut into tiles. Within a tile errors go together (windows
overlap, a surface is smooth or a texture repeats), so the formal least-squares covariance is too small: tiles are the
units of resampling.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.decision import ENOUGH
from stereorecal.estimation import nearness_of
from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import LinearRows, Reach, RigChart, linearised, row_chart
from stereorecal.recalibration import DISTANCES, RowResiduals, is_sparse, watching_scale
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, Loss, curvatures, host, image_quality, precisions, pyramid

_FALSE = 0.4  # pixels left: chance matches lie evenly within a row of where they were sought, median 0.5
# From afar to the end; the weights follow the solution. Rows are taken as linear: a rig that is watched is not far off.
_LOSSES = (Loss.SOFT_L1, Loss.WELSCH, Loss.WELSCH, Loss.WELSCH)
# Standard deviation of an offset that all rows share, pixels of the images that were measured: no resampling sees it.
_SHARED = 0.005
PARTS = (3, 3)  # rows and columns of the left image
# Baselines, halfway between the distances at which depth is read.
BAND_EDGES = tuple(np.sqrt(np.multiply(DISTANCES[:-1], DISTANCES[1:])).tolist())


@dataclass(frozen=True, eq=False, kw_only=True)
class RowSolution(RowResiduals):
    """The least-squares problem at the solution, linear in z, the point of the unit box.

    Attributes:
        z: (n,) the solution.
        jacobian: (m, n) of the row differences, pixels at full size.
        weight: (m,) of the squared row differences.
        curvature: (m,) second derivatives of their losses.
        prior: standard deviation of the drift on each axis, in half widths of the box.
        scale: pixels at which the rows were measured, per pixel at full size.
    """

    z: Float[np.ndarray, "n"]
    jacobian: Float[np.ndarray, "m n"]
    weight: Float[np.ndarray, "m"]
    curvature: Float[np.ndarray, "m"]
    prior: float
    scale: float = 1.0

    @property
    def normal(self) -> Float[np.ndarray, "n n"]:
        """The normal matrix with the prior's, of the curvatures of the losses."""
        return self._normal(slice(None)) + self._prior

    @property
    def _prior(self) -> Float[np.ndarray, "n n"]:
        return np.eye(len(self.z)) / self.prior**2

    def _normal(self, rows) -> Float[np.ndarray, "n n"]:
        jacobian = self.jacobian[rows]
        return jacobian.T @ (self.curvature[rows, None] * jacobian)

    def _pull(self, rows) -> Float[np.ndarray, "n"]:
        return self.jacobian[rows].T @ (self.weight[rows] * self.residual[rows])

    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Of the solution, in units of the box: the jackknife over places, and the prior.

        Each place is left out in turn; how the solution moves then, to first order, is what the data can say of its
        scatter (Efron & Stein 1981; for clusters in least squares: Bell & McCaffrey 2002). What they cannot say, the
        prior does; and an offset that all rows share (of the interpolation, or of two shutters) is added.
        """
        left_out = [np.flatnonzero(self.place == one) for one in np.unique(self.place)]
        if len(left_out) < 2:
            return np.linalg.inv(self._prior)
        normal = self.normal
        pull = self._pull(slice(None)) + self._prior @ self.z
        moves = np.stack([np.linalg.solve(normal - self._normal(p), pull - self._pull(p)) for p in left_out])
        inverse = np.linalg.inv(normal)
        shared = _SHARED / self.scale * inverse @ (self.jacobian.T @ self.curvature)
        return _jackknife(moves) + inverse @ self._prior @ inverse + np.outer(shared, shared)


@dataclass(frozen=True, eq=False)
class PairEstimate:
    """The estimate of the rig by one pair.

    Attributes:
        chart: around the calibration that was looked through.
        solution: what they say, at the offset `solution.z` to the true rig, in half widths of the chart's box; None if
            too little matches, or what matches does so by chance.
        found: the correspondences that they rest on.
    """

    chart: RigChart
    solution: RowSolution | None = None
    found: Correspondences | None = None

    @property
    def match_radius(self) -> float:
        """Pixels: what is farther from all correspondences is of something else."""
        assert self.found is not None
        return host.match_radius(self.found, self.chart.rig)

    @property
    def matches(self) -> host.Matches:
        """Pixels that correspond."""
        assert self.found is not None
        return host.Matches.of(self.found, self.chart.rig)

    def row_error(self, rig: StereoRig) -> float:
        """|Row difference| under a rig, pixels at full size: the mean over the tiles of a tile's median."""
        solution = self.solution
        assert solution is not None
        way = self.chart.coordinates(np.asarray(rig.extrinsics))
        return float(np.mean(solution.medians(solution.start_residual + solution.jacobian @ way)))


def estimate_pair(rig: StereoRig, pair: Pair, view: View, matcher: AbstractMatcher) -> PairEstimate:
    """Match a pair, and solve once for the offset."""
    data = pyramid(rig, [pair], view).at(watching_scale(rig.left.size))
    chart = row_chart(rig, Reach())
    found = host.correspondences(data, with_unit_baseline(rig.extrinsics), matcher)
    if found.found < ENOUGH.matches or found.covered < ENOUGH.covered:
        return PairEstimate(chart)
    start = linearised(found, chart, np.zeros(chart.dim))
    solution = _row_solution(found, start, chart.prior)
    if solution.places < ENOUGH.places or (
        np.mean(solution.medians(solution.residual)) * solution.scale > _FALSE
        and is_sparse(found.covered, image_quality(pair).texture)
    ):
        return PairEstimate(chart)
    return PairEstimate(chart, solution, found)


def _row_solution(found: Correspondences, start: LinearRows, prior: float) -> RowSolution:
    """The solution of the rows of correspondences, from those under the initial calibration."""
    rows, valid, scale = _solved_robustly(found, start, prior), np.asarray(found.weight) > 0, float(found.scale)
    return RowSolution(
        residual=rows.differences[valid] / scale,
        start_residual=start.differences[valid] / scale,
        tile=np.asarray(found.tile)[valid],
        independent=float(found.independent),
        z=rows.z,
        jacobian=rows.jacobian[:, valid].T / scale,
        weight=precisions(found, rows.differences, Loss.WELSCH)[valid] * scale**2,
        curvature=curvatures(found, rows.differences)[valid] * scale**2,
        prior=prior,
        scale=scale,
    )


def _solved_robustly(found: Correspondences, start: LinearRows, prior: float) -> LinearRows:
    """The rows where they meet best; the prior holds what they cannot tell."""
    z, differences = start.z, start.differences.reshape(-1)
    jacobian, held = start.jacobian.reshape(len(z), -1), np.eye(len(z)) / prior**2
    for loss in _LOSSES:
        weight = precisions(found, (differences + z @ jacobian).reshape(start.differences.shape), loss).reshape(-1)
        z = -np.linalg.solve((jacobian * weight) @ jacobian.T + held, (jacobian * weight) @ differences)
    return LinearRows(z, start.differences + (z @ jacobian).reshape(start.differences.shape), start.jacobian)


def _jackknife(ends: Float[np.ndarray, "u n"]) -> Float[np.ndarray, "n n"]:
    """The covariance that solutions without one of u units each show (Efron & Stein 1981), wider for few units, so that
    1.96 standard deviations mean 95 % of them too."""
    from scipy.special import stdtrit  # a third of a second to import, for one number

    moves, degrees = ends - ends.mean(0), len(ends) - 1
    scatter = moves.T @ moves * degrees / len(ends)
    return (float(stdtrit(degrees, 0.975)) / NormalDist().inv_cdf(0.975)) ** 2 * scatter


def part_of(rig: StereoRig, points: Float[np.ndarray, "p 3"]) -> Int[np.ndarray, "p"]:
    """The part of the left image in which each point appears, numbered by rows."""
    pixels = np.asarray(rig.left.project(points / points[:, 2:]))
    share = pixels / np.array(rig.left.size) * PARTS[::-1]
    column, row = np.clip(share.astype(int), 0, np.array(PARTS[::-1]) - 1).T
    return row * PARTS[1] + column


def as_taken(part: int, rig: StereoRig) -> tuple[int, int]:
    """Row and column of a part in the left image as it was taken, before the rig's `turns`."""
    numbers = np.arange(PARTS[0] * PARTS[1]).reshape(PARTS)
    row, column = np.argwhere(np.rot90(numbers, -rig.turns[0]) == part)[0].tolist()
    return row, column


def band_of(baselines: Float[np.ndarray, "*n"] | float) -> Int[np.ndarray, "*n"]:
    """The number of the distance that each distance counts to."""
    return np.searchsorted(BAND_EDGES, baselines)


def no_coverage() -> Int[np.ndarray, "parts distances"]:
    """The coverage before the first look."""
    return np.zeros((PARTS[0] * PARTS[1], len(DISTANCES)), int)


def covered_by(look: PairEstimate, view: View) -> Bool[np.ndarray, "parts distances"]:
    """Whether a look shows each part of the view at each distance: in as large a share of the part as a whole image
    must be covered by."""
    found, rig = look.found, look.chart.rig
    assert found is not None
    valid = np.asarray(found.weight[0]) > 0
    left, right = (np.asarray(rays[0], float)[valid] for rays in (found.left, found.right))
    away = 1.0 / np.maximum(nearness_of(rig, left, right, view), 1e-9)
    counts = no_coverage()
    np.add.at(counts, (part_of(rig, left), band_of(away)), 1)
    return counts >= ENOUGH.covered * found.weight.shape[1] / len(counts)
