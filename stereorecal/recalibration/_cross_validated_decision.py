"""What frames that took no part say of other intrinsics."""

from collections.abc import Sequence

import numpy as np

from stereorecal.decision import Decision, Tolerances, Verdict, decide, with_nearest_distance
from stereorecal.estimation import Estimate, Prior, as_prior, estimate, frames_by_place, is_exact, largest_loss
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._unmatched import without_frames_of
from stereorecal.scoring import Correspondences

_PARTS = 4  # of the places, each left out once


def shows_several_places(estimated: Estimate) -> bool:
    """Whether frames that take no part can be asked."""
    return estimated.shown is not None and len(frames_by_place(estimated.shown)) >= _PARTS


def asks_for_intrinsics(estimated: Estimate, held: Decision) -> bool:
    """Whether a decision on extrinsics leaves rows that intrinsics might explain; what a late shutter leaves, they do
    not."""
    return held.verdict is not Verdict.GOOD and not held.explains and not estimated.is_late


def decided_by_cross_validation(
    estimated: Estimate,
    found: Correspondences,
    rig: StereoRig,
    prior: Prior,
    free: Sequence[str],
    tolerances: Tolerances,
) -> Decision | None:
    """The decision on free parameters, if it is a repair that explains the rows, and frames of several places bear it
    out: under the rig that the other places tell, rows of none of them, and of no region of the view, are worse.

    Args:
        found: that the estimate rests on, as the cameras of the given rig read them.
        rig: the given one.
        free: names, with intrinsics among them.
    """
    if estimated.shown is None or is_exact(prior) or not shows_several_places(estimated):
        return None
    places = frames_by_place(estimated.shown)
    freed = decide(estimated, free, tolerances, proven=True)
    if freed.refused or not freed.explains:
        return None
    groups, known = estimated.shown, as_prior(prior, estimated.chart)
    before = groups.differences(estimated.chart, np.zeros(estimated.chart.dim))
    after = np.full_like(before, np.nan)
    for part in range(_PARTS):
        left_out = tuple(frame for place in places[part::_PARTS] for frame in place)
        training_estimate = estimate(
            without_frames_of(found, left_out), rig, known, start=estimated.theta, view=estimated.view
        )
        theta = with_nearest_distance(training_estimate, tolerances).with_free(free, keep_depth=freed.keeps_depth)
        held_out = np.isin(groups.frame, left_out)
        after[held_out] = groups.differences(estimated.chart, theta)[held_out]
    return freed if largest_loss(groups, before, after) <= tolerances.worse_rows_px else None
