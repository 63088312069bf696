"""The common estimate of recordings of one rig, and the rigs that it gives them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import ENOUGH, Decision, Reason, Seen, Tolerances, decide_together, reason_of
from stereorecal.estimation import (
    NO_RANGES,
    CalibrationPrior,
    Each,
    Earlier,
    Estimate,
    MatchedRanges,
    Recording,
    SavedPrior,
    as_prior,
    estimate_together,
    rig_parameters,
    with_free_together,
)
from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameters, row_chart
from stereorecal.recalibration._assessment import turned_by
from stereorecal.recalibration._prior_use import prior_of
from stereorecal.recalibration._repaired_recording import RepairedRecording
from stereorecal.recalibration._row_residuals import RowResiduals, places_of, row_residuals
from stereorecal.recalibration._tile_counts import share_lost
from stereorecal.recalibration._unmatched import MOST_EXCLUDED
from stereorecal.recalibration._worker_tasks import matched, range_matches
from stereorecal.scoring import Correspondences, with_rays_of


@dataclass(frozen=True, eq=False)
class JointEstimate:
    """What recordings say together.

    Attributes:
        recordings: those that take part.
        free: own and shared parameters.
        estimated_from: the matches of each recording.
        estimates, decisions: of each recording; candidates have the same shared parameters.
        ranges: the ranges of each recording that have a reliable match.
    """

    recordings: Sequence[RepairedRecording]
    free: Parameters
    estimated_from: tuple[Recording, ...]
    estimates: tuple[Estimate, ...]
    decisions: tuple[Decision, ...]
    ranges: tuple[MatchedRanges, ...]

    def rig(self, index: int) -> StereoRig:
        """The rig that a recording gets: at the candidate of its estimate."""
        return self.estimates[index].chart.rig_at(self.decisions[index].theta)

    def rows(self, at: int, theta: Float[np.ndarray, "n"]) -> RowResiduals:
        """What is left at a θ of an estimate, and under the initial rig."""
        repair, estimated = self.recordings[at].repair, self.estimates[at]
        chart = row_chart(repair.initial, repair.settings.reach, self.free)
        return row_residuals(chart, self.estimated_from[at].found, estimated.chart.rig_at(theta))

    def reason(self, at: int, tiles: Int[np.ndarray, "2 k tiles"]) -> Reason:
        """What is said of the rig of an estimate; its tiles have these counts before and after."""
        estimated, found = self.estimates[at], self.estimated_from[at].found
        repair, candidate = self.recordings[at].repair, self.rig(at)
        seen = replace(
            repair.seen or Seen(),
            matches=found.found,
            covered=found.covered,
            places=len(places_of(found)),
            frames_disagree=len(estimated.other_rigs) > MOST_EXCLUDED * len(found.weight),
            late=estimated.is_late,
            misfit_px=max(estimated.misfit),
            lost=share_lost(tiles),
            away=turned_by(repair.initial, candidate, repair.settings.reach),
        )
        return reason_of(self.decisions[at], seen)


def joint_estimate(recordings: Sequence[RepairedRecording], free: Parameters, each: Each) -> JointEstimate:
    """The joint estimate of recordings: solved, matched again, solved again.

    Args:
        free: own and shared.
        each: runs a task for each recording.
    """
    ranges = (NO_RANGES,) * len(recordings)
    if any(r.ranges for r in recordings):
        ranges = tuple(each(range_matches, [r.task(r.repair.candidate, ranges=True) for r in recordings]))
    priors, estimated_from = _priors(recordings, free), []
    for r, prior, some in zip(recordings, priors, ranges, strict=True):
        start = _start(r, r.repair.candidate)
        estimated_from.append(Recording(r.found, r.repair.initial, prior, start, some, r.windows, r.repair.view))
    tolerances = recordings[0].repair.settings.tolerances
    estimates = _estimates(estimated_from, tolerances, each)
    likely = with_free_together(estimates, free.names)
    rigs = [estimate.chart.rig_at(theta) for estimate, theta in zip(estimates, likely, strict=True)]
    again = each(matched, [r.task(rig) for rig, r in zip(rigs, recordings, strict=True)])
    estimated_from = [
        replace(before, found=_as_initially_read(found, rig, r), start=_start(r, rig))
        for before, r, found, rig in zip(estimated_from, recordings, again, rigs, strict=True)
    ]
    estimates = _estimates(estimated_from, tolerances, each)
    decisions = tuple(decide_together(estimates, free.names, tolerances))
    return JointEstimate(recordings, free, tuple(estimated_from), estimates, decisions, ranges)


def _estimates(several: Sequence[Recording], tolerances: Tolerances, each: Each) -> tuple[Estimate, ...]:
    return tuple(one.judged_by(tolerances.matters) for one in estimate_together(several, each=each))


def _priors(recordings: Sequence[RepairedRecording], free: Parameters) -> list[CalibrationPrior]:
    """The prior of each recording of a joint estimate: the saved one of its calibration, or the common one."""
    ranges, common, found = any(r.ranges or r.windows.measured for r in recordings), None, []
    for repair in (recording.repair for recording in recordings):
        prior = None if repair.prior_use is None else repair.prior_use.prior
        known = common
        if known is None or isinstance(prior, SavedPrior | Earlier):
            known = prior_of(prior, free, repair.initial, repair.settings.reach, ranges=ranges)
            known = as_prior(known, rig_parameters(repair.initial))
        if not isinstance(prior, SavedPrior | Earlier):
            common = known
        found.append(known)
    return found


def _start(recording: RepairedRecording, rig: StereoRig) -> Float[np.ndarray, "n"]:
    return rig_parameters(recording.repair.initial).coordinates_of(rig)


def _as_initially_read(found: Correspondences, matched_rig: StereoRig, recording: RepairedRecording) -> Correspondences:
    """Correspondences of another rig as the initial one reads them; those from before, if they are too few."""
    return (
        with_rays_of(recording.repair.initial, found, matched_rig=matched_rig)
        if found.found >= ENOUGH.matches
        else recording.found
    )
