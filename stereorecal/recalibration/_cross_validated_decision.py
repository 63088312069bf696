"""What frames that took no part say of other intrinsics."""

from collections.abc import Sequence

import numpy as np

from stereorecal.decision import Decision, Tolerances, decide, with_nearest_distance
from stereorecal.estimation import Estimate, Prior, as_prior, estimate, frames_by_place, is_exact, largest_loss
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._unmatched import without_frames_of
from stereorecal.scoring import Correspondences

_PARTS = 4  # of the places, each left out once


def decided_by_cross_validation(
    seen: Estimate,
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
    if seen.shown is None or is_exact(prior) or len(places := frames_by_place(seen.shown)) < _PARTS:
        return None
    freed = decide(seen, free, tolerances, proven=True)
    if freed.refused or not freed.explains:
        return None
    shown, known = seen.shown, as_prior(prior, seen.chart)
    before = shown.differences(seen.chart, np.zeros(seen.chart.dim))
    after = np.full_like(before, np.nan)
    for part in range(_PARTS):
        left_out = tuple(frame for place in places[part::_PARTS] for frame in place)
        others = estimate(without_frames_of(found, left_out), rig, known, start=seen.theta, view=seen.view)
        theta = with_nearest_distance(others, tolerances).with_free(free, keep_depth=freed.keeps_depth)
        here = np.isin(shown.frame, left_out)
        after[here] = shown.differences(seen.chart, theta)[here]
    return freed if largest_loss(shown, before, after) <= tolerances.worse_rows_px else None
