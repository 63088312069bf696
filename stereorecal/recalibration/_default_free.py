"""The parameters that a repair frees where nothing is said: the extrinsics, or all where frames bear that out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereorecal.decision import Decision, Verdict, decide
from stereorecal.estimation import Estimate, as_prior, estimate, frames_by_place, is_exact, largest_loss
from stereorecal.objectives import Parameters
from stereorecal.recalibration._stages import Case
from stereorecal.recalibration._unmatched import without
from stereorecal.scoring import Correspondences

_PARTS = 4  # of the places, each left out once


def widened(case: Case, found: Correspondences, seen: Estimate, held: Decision) -> tuple[Parameters, Decision]:
    """What may change, and the decision on it: as it is in the case; or everything, where that does not explain the
    rows of several places, and all parameters together do, also in frames that took no part.

    Args:
        found: that the estimate rests on.
        held: the decision on what is free in the case.
    """
    if not case.free.widens or held.verdict is Verdict.GOOD or held.explains or seen.shown is None:
        return case.free, held
    if is_exact(case.prior) or len(places := frames_by_place(seen.shown)) < _PARTS:
        return case.free, held
    free = case.free.widest(case.rig)
    freed = decide(seen, free.names, case.tolerances, proven=True)
    if freed.refused or not freed.explains:
        return case.free, held
    lost = _lost_where_left_out(case, found, seen, places, free.names, keep_depth=freed.keeps_depth)
    return (free, freed) if lost <= case.tolerances.worse_rows_px else (case.free, held)


def _lost_where_left_out(
    case: Case,
    found: Correspondences,
    seen: Estimate,
    places: Sequence[tuple[int, ...]],
    free: Sequence[str],
    *,
    keep_depth: bool,
) -> float:
    """By how much rows grow at most, in a frame or a region of the view, under the rig that the other places tell."""
    shown, prior = seen.shown, as_prior(case.prior, seen.chart)
    assert shown is not None
    before = shown.differences(seen.chart, np.zeros(seen.chart.dim))
    after = np.full_like(before, np.nan)
    for part in range(_PARTS):
        left_out = tuple(frame for place in places[part::_PARTS] for frame in place)
        others = estimate(without(found, left_out), case.rig, prior, start=seen.theta, view=seen.view)
        theta = replace(others, judged_at=case.tolerances.distances).with_free(free, keep_depth=keep_depth)
        here = np.isin(shown.frame, left_out)
        after[here] = shown.differences(seen.chart, theta)[here]
    return largest_loss(shown, before, after)
