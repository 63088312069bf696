"""One look through a calibration: a match, its correspondences, and the one linear solve that they allow. No search."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach, SearchBox, linearised, row_box
from stereorecal.recalibration._evidence import Evidence, evidence
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
        box: around the calibration that was looked through, its centre, with the default prior on the drift.
        found: the correspondences.
        facts: the least-squares problem at its solution; None if there are too few correspondences for one.
        score: the count, at full scale.
    """

    box: SearchBox
    found: Correspondences
    facts: Evidence | None
    score: Score


def look(images: Pyramid, matcher: AbstractMatcher) -> Look:
    """Match the images under the calibration of their rig, at the scale of the last stage of a repair, and solve once.
    Large images are matched again at full scale for the count.

    Args:
        matcher: with its disparity range at full size.
    """
    data, box = images.at(finest_scale(images.rig.left.size)), row_box(images.rig, Reach())
    extrinsics, whole = with_unit_baseline(images.rig.extrinsics), images.at(1.0)
    found, count = host.correspondences_and_count(data, extrinsics, matcher)
    if data is not whole:
        count = int(host.counts_one_by_one(whole, extrinsics[None], matcher)[0])
    facts = evidence(box, found, solved(found, box)) if found.found >= FEWEST else None
    return Look(box, found, facts, Score(count, whole.pixels))


def solved(found: Correspondences, box: SearchBox) -> Float[np.ndarray, "n"]:
    """The point of the box at which the rows meet best, linear around its centre; the prior holds what rows cannot."""
    z = np.zeros(len(box.chart.free))
    prior = np.eye(len(z)) / box.prior**2
    rows = linearised(found, box.chart, z)
    jacobian = rows.jacobian.reshape(len(z), -1)
    for loss in _LOSSES:
        weighted = jacobian * precisions(found, rows.differences, loss).reshape(-1)
        pull = weighted @ rows.differences.reshape(-1) + prior @ z
        z = z - np.linalg.solve(weighted @ jacobian.T + prior, pull)
        rows = rows.moved(found, box.chart, z)
    return z
