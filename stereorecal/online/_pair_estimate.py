"""One look at one pair through the calibration in use, at half scale: what it measures, and how well."""

from dataclasses import dataclass

import numpy as np

from stereorecal.decision import ENOUGH
from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import LinearRows, Reach, RigChart, linearised, row_chart
from stereorecal.online._row_solution import RowSolution, row_solution
from stereorecal.recalibration import is_sparse, watching_scale
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, Loss, host, image_quality, precisions, pyramid

_FALSE = 0.4  # pixels left: chance matches lie evenly within a row of where they were sought, median 0.5
# From afar to the end; the weights follow the solution. Rows are taken as linear: a rig that is watched is not far off.
_LOSSES = (Loss.SOFT_L1, Loss.WELSCH, Loss.WELSCH, Loss.WELSCH)


@dataclass(frozen=True, eq=False)
class PairEstimate:
    """The estimate of the rig by one pair.

    Attributes:
        chart: around the calibration that was looked through.
        covered: share of the image in which correspondences were found.
        solution: what they say, at the offset `solution.z` to the true rig, in half widths of the chart's box; None if
            too little matches, or what matches does so by chance.
        found: the correspondences that they rest on.
    """

    chart: RigChart
    covered: float
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

    def rows(self, rig: StereoRig) -> float:
        """|Row difference| under a rig, pixels at full size: the mean over the tiles of a tile's median."""
        solution = self.solution
        if solution is None:
            return float("nan")
        way = self.chart.coordinates(np.asarray(rig.extrinsics))
        return float(np.mean(solution.medians(solution.start_residual + solution.jacobian @ way)))


def estimate_pair(rig: StereoRig, pair: Pair, view: View, matcher: AbstractMatcher) -> PairEstimate:
    """Match a pair, and solve once for the offset.

    Args:
        matcher: with its disparity range at full size.
    """
    data = pyramid(rig, [pair], view).at(watching_scale(rig.left.size))
    chart = row_chart(rig, Reach())
    found = host.correspondences(data, with_unit_baseline(rig.extrinsics), matcher)
    if found.found < ENOUGH.matches or found.covered < ENOUGH.covered:
        return PairEstimate(chart, found.covered)
    start = linearised(found, chart, np.zeros(chart.dim))
    solution = row_solution(found, _solved_robustly(found, start, chart.prior), start.differences, chart.prior)
    if solution.places < ENOUGH.places or (
        np.mean(solution.medians(solution.residual)) * solution.scale > _FALSE
        and is_sparse(found.covered, image_quality(pair).texture)
    ):
        return PairEstimate(chart, found.covered)
    return PairEstimate(chart, found.covered, solution, found)


def _solved_robustly(found: Correspondences, start: LinearRows, prior: float) -> LinearRows:
    """The rows where they meet best; the prior holds what they cannot tell."""
    z, differences = start.z, start.differences.reshape(-1)
    jacobian, held = start.jacobian.reshape(len(z), -1), np.eye(len(z)) / prior**2
    for loss in _LOSSES:
        weight = precisions(found, (differences + z @ jacobian).reshape(start.differences.shape), loss).reshape(-1)
        z = -np.linalg.solve((jacobian * weight) @ jacobian.T + held, (jacobian * weight) @ differences)
    return LinearRows(z, start.differences + (z @ jacobian).reshape(start.differences.shape), start.jacobian)
