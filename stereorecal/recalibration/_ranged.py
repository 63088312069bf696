"""Repairs with ranges: these are matched where the search ended, and may tell what rows cannot."""

from collections.abc import Sequence

from stereorecal.estimation import NO_BEAMS, Beams, Estimate, Prior, as_prior, is_exact, rig_parameters, with_deviations
from stereorecal.geometry import StereoRig
from stereorecal.objectives import EXTRINSICS, Parameters, Reach
from stereorecal.recalibration._acceptance import Reason, Verdict
from stereorecal.recalibration._ranges import RangesSeen, beams
from stereorecal.recalibration._stages import Case
from stereorecal.scoring import Correspondences

_MOST_WORSE = 0.01  # probability


def prior_of(prior: Prior, free: Parameters, rig: StereoRig, reach: Reach, *, ranges: bool) -> Prior:
    """What is known of the calibration: the prior, with what `free` says of single parameters. Where all is exact, what
    is free and no drift moves is as uncertain as `free` has it."""
    said = {name: sigma for name, sigma in free.priors.items() if name not in EXTRINSICS}
    if is_exact(prior):
        said = {one.name: one.sigma for one in free.of(rig, reach) if one.name in free.shared}
    if not said:
        return prior
    chart = rig_parameters(rig)
    return with_deviations(as_prior(prior, chart, told_length=ranges), chart, said)


def matched_ranges(case: Case, found: Correspondences, near: StereoRig, apart: Sequence[int] = ()) -> Beams:
    """The ranges of a case that have a sure match, without those of some frames.

    Args:
        found: the correspondences beside which they are matched.
        near: where the search ended, with the cameras of the case's rig.
    """
    away = [case.images.pairs[frame] for frame in apart]
    ranges = [one for one in case.ranges if not any(one.pair is pair for pair in away)]
    if not ranges:
        return NO_BEAMS
    return beams(case.images.at(float(found.scale)), near, case.matcher, case.images.pairs, ranges)


def said_by_ranges(said: Verdict, seen: Estimate, candidate: StereoRig) -> Verdict:
    """The verdict on a candidate: where rows gain nothing, ranges may still tell that the calibration before was
    wrong, of a candidate that is hardly worse."""
    if said != Verdict(Reason.ALREADY_GOOD) or not seen.beams.fit_better(seen.chart.rig, candidate):
        return said
    worse = seen.probability_worse(seen.chart.coordinates_of(candidate))
    return Verdict(Reason.RANGES) if worse < _MOST_WORSE else said


def ranges_seen(given: int, matched: Beams, initial: StereoRig, candidate: StereoRig, said: Reason) -> RangesSeen:
    """What became of so many ranges."""
    used = candidate if said.accepted else initial
    refused = None if said.accepted or not matched.fit_better(initial, candidate) else said
    return RangesSeen(given, len(matched.metres), int(matched.contradict(used).sum()), refused)
