"""Repairs with ranges: these are matched where the search ended, and may tell what rows cannot."""

from collections.abc import Sequence

from stereorecal.decision import Reason
from stereorecal.estimation import NO_RANGES, MatchedRanges
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import RangesSeen, match_ranges
from stereorecal.scoring import Correspondences


def matched_ranges(
    case: Case, found: Correspondences, end_rig: StereoRig, excluded: Sequence[int] = ()
) -> MatchedRanges:
    """The ranges of a case that have a sure match, without those of some frames.

    Args:
        found: the correspondences beside which they are matched.
        end_rig: where the search ended, with the cameras of the case's rig.
    """
    away = [case.images.pairs[frame] for frame in excluded]
    ranges = [one for one in case.ranges if not any(one.pair is pair for pair in away)]
    if not ranges:
        return NO_RANGES
    return match_ranges(case.images.at(float(found.scale)), end_rig, case.matcher, case.images.pairs, ranges)


def ranges_seen(
    given: int, matched: MatchedRanges, initial: StereoRig, candidate: StereoRig, reason: Reason
) -> RangesSeen | None:
    """What became of so many ranges; None if there were none."""
    if not given:
        return None
    used = candidate if reason.accepted else initial
    refused = None if reason.accepted or not matched.fit_better(initial, candidate) else reason
    return RangesSeen(given, len(matched.metres), int(matched.contradict(used).sum()), refused)
