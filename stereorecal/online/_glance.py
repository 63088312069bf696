"""One look at one pair through the calibration in use, at half scale: what it measures, and how well."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach, RigChart, differences_at, row_chart
from stereorecal.recalibration import FEWEST, FEWEST_PLACES, LEAST_COVERED, evidence, solved, watching_scale
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, host, pyramid


@dataclass(frozen=True, eq=False)
class Glance:
    """What a look shows.

    Attributes:
        chart: around the calibration that was looked through.
        found: the correspondences.
        covered: share of the image in which there are some.
        offset: (5,) to the true rig, in half widths of the chart's box; None if too little matches.
        covariance: (5, 5) of it.
        steepness: (5, 5) mean of the squared derivatives of the rows, pixels at full size.
    """

    chart: RigChart
    found: Correspondences
    covered: float
    offset: Float[np.ndarray, "5"] | None = None
    covariance: Float[np.ndarray, "5 5"] | None = None
    steepness: Float[np.ndarray, "5 5"] | None = None

    def rows(self, rig: StereoRig) -> float:
        """|Row difference| under a rig, pixels at full size: the mean over the tiles of a tile's median."""
        found, here = self.found, np.asarray(self.found.weight) > 0
        apart = np.abs(differences_at(found, self.chart, self.chart.coordinates(np.asarray(rig.extrinsics))))[here]
        tile = np.asarray(found.tile)[here]
        medians = [np.median(apart[tile == one]) for one in np.unique(tile)]
        return float(np.mean(medians) / float(found.scale)) if medians else float("nan")


def glance(rig: StereoRig, pair: Pair, view: View, matcher: AbstractMatcher) -> Glance:
    """Match a pair, and solve once for the offset.

    Args:
        matcher: with its disparity range at full size.
    """
    data = pyramid(rig, [pair], view).at(watching_scale(rig.left.size))
    chart = row_chart(rig, Reach())
    found = host.correspondences(data, with_unit_baseline(rig.extrinsics), matcher)
    if found.found < FEWEST or found.covered < LEAST_COVERED:
        return Glance(chart, found, found.covered)
    facts = evidence(chart, found, solved(found, chart))
    if facts.places < FEWEST_PLACES:
        return Glance(chart, found, found.covered)
    steepness = facts.jacobian.T @ facts.jacobian / len(facts.residual)
    return Glance(chart, found, found.covered, facts.z, facts.covariance(), steepness)
