"""One look through a calibration: a match, its correspondences, and the one linear solve that they allow. No search."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach, RigChart, linearised, row_chart
from stereorecal.recalibration._agreement import Agreement, agreed
from stereorecal.recalibration._schedule import finest_scale
from stereorecal.recalibration._stages import FEWEST
from stereorecal.scoring import Correspondences, Loss, Pyramid, host, precisions
from stereorecal.scoring.host import Score

# From afar to the end, as the first round of a repair; the weights follow the solution, the correspondences stay.
_LOSSES = (Loss.SOFT_L1, Loss.WELSCH, Loss.WELSCH, Loss.WELSCH)


@dataclass(frozen=True, eq=False)
class Look:
    """What one look shows.

    Attributes:
        chart: around the calibration that was looked through, its centre, with the default prior on the drift.
        found: the correspondences.
        frames: what they say together, at the solution; None if there are too few correspondences for one.
        score: the count, at full scale.
    """

    chart: RigChart
    found: Correspondences
    frames: Agreement | None
    score: Score


def look(images: Pyramid, matcher: AbstractMatcher) -> Look:
    """Match the images under the calibration of their rig, at the scale of the last stage of a repair, and solve once.
    Large images are matched again at full scale for the count.

    Args:
        matcher: with its disparity range at full size.
    """
    data, chart = images.at(finest_scale(images.rig.left.size)), row_chart(images.rig, Reach())
    extrinsics, whole = with_unit_baseline(images.rig.extrinsics), images.at(1.0)
    found, count = host.correspondences_and_count(data, extrinsics, matcher)
    if data is not whole:
        count = int(host.counts_one_by_one(whole, extrinsics[None], matcher)[0])
    frames = agreed(chart, found, solved(found, chart), images.pairs) if found.found >= FEWEST else None
    return Look(chart, found, frames, Score(count, whole.pixels))


def solved(found: Correspondences, chart: RigChart) -> Float[np.ndarray, "n"]:
    """The point of the box at which the rows meet best, linear around its centre; the prior holds what rows cannot."""
    z = np.zeros(chart.dim)
    prior = np.eye(len(z)) / chart.prior**2
    rows = linearised(found, chart, z)
    jacobian = rows.jacobian.reshape(len(z), -1)
    for loss in _LOSSES:
        weighted = jacobian * precisions(found, rows.differences, loss).reshape(-1)
        pull = weighted @ rows.differences.reshape(-1) + prior @ z
        z = z - np.linalg.solve(weighted @ jacobian.T + prior, pull)
        rows = rows.moved(found, chart, z)
    return z
