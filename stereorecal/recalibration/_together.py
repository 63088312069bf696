"""The joint solution of recordings of the same cameras, which share intrinsics and the length of the baseline: one
estimate of those that show one calibration, and one decision.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import ENOUGH, Decision, Reason, Seen, decide_together, reason_of
from stereorecal.estimation import (
    NEGLIGIBLE,
    NO_RANGES,
    NO_WINDOWS,
    Estimate,
    Fit,
    MatchedRanges,
    Mixture,
    Recording,
    SavedPrior,
    Windows,
    agreement,
    as_prior,
    beside_others,
    fitted,
    fitted_together,
    most_probable,
    rig_parameters,
    with_free_together,
)
from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, Parameters
from stereorecal.recalibration._assessment import MOST_EXCLUDED, counts, with_candidate, without_frames_of
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import RangesSeen, match_ranges
from stereorecal.recalibration._prior_use import prior_of
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import matched, with_found
from stereorecal.recalibration._uncertainty import Intrinsics, IntrinsicsOutcome, intrinsics_of
from stereorecal.scoring import Correspondences
from stereorecal.scoring.host import Score

_UNUSABLE = (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES, Reason.FRAMES_DISAGREE)

# Calls a function with each of some arguments, as `map` does, somewhere: the function and they travel.
Each = Callable[..., list[Any]]


def matched_again(case: Case, scale: float, theta: Float[np.ndarray, "n"]) -> Correspondences:
    """The correspondences under the rig at θ."""
    return matched(case.anew.images.at(scale), rig_parameters(case.rig), theta, case.matcher)


def range_matches(case: Case, scale: float, rig: StereoRig, used: Sequence[int]) -> MatchedRanges:
    """The ranges of the frames that are used, matched under a rig."""
    pairs, data = case.images.pairs, case.anew.images.at(scale).through(rig)
    ranges = [one for one in case.ranges if any(one.pair is pairs[frame] for frame in used)]
    return match_ranges(data, rig, case.matcher, pairs, ranges)


def counted(case: Case, candidate: StereoRig) -> Int[np.ndarray, "2 k tiles"]:
    """Counts of the tiles of all frames at full scale, under the initial rig and the candidate."""
    return counts(case.anew, candidate)


@dataclass(frozen=True, eq=False)
class RepairedRecording:
    """A recording, with the disparity range of its repair by itself, and that; the frames that it left out take no
    part.
    """

    case: Case
    repair: Solution

    @property
    def scale(self) -> float:
        """At which it was matched."""
        return self.repair.stages[-1].scale

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """Where its candidate lies, counted from the initial rig."""
        return rig_parameters(self.case.rig).coordinates_of(self.repair.candidate)

    @property
    def found(self) -> Correspondences:
        """The last correspondences of the repair.

        Raises:
            ValueError: if it is not usable.
        """
        if self.repair.found is None:
            raise ValueError("a recording without correspondences has no part in a joint solution")
        return self.repair.found

    @property
    def windows(self) -> Windows:
        """The windows of the pairs that follow each other."""
        return NO_WINDOWS if self.repair.estimate is None else self.repair.estimate.windows

    @property
    def usable(self) -> bool:
        """Whether it can take part."""
        found, by_chance = self.repair.found, (self.repair.seen or Seen()).by_chance
        enough = found is not None and found.found >= ENOUGH.matches
        return enough and not by_chance and self.repair.reason not in _UNUSABLE

    @property
    def excluded(self) -> tuple[int, ...]:
        """Numbers of the frames that it left out."""
        return tuple(set(range(len(self.case.images.pairs))) - set(self.repair.used))


@dataclass(frozen=True, eq=False)
class Member:
    """What a recording says beside the others.

    Attributes:
        found: the matches that the estimate rests on.
        decision: of all recordings together; candidates have the same shared parameters.
    """

    recording: RepairedRecording
    found: Correspondences
    estimate: Estimate
    decision: Decision

    @property
    def rig(self) -> StereoRig:
        """The rig that the recording gets: the candidate."""
        return self.estimate.chart.rig_at(self.decision.theta)


def joint_estimate(recordings: Sequence[RepairedRecording], free: Parameters, each: Each) -> list[Member]:
    """The joint estimate of recordings, without those that show another calibration: fitted, matched again, weighed;
    and the decision on it. Empty, where those are too many to say which they are; `each` is as `Each`."""
    cases, scales = [r.case for r in recordings], [r.scale for r in recordings]
    ranges = [NO_RANGES for _ in cases]
    if any(case.ranges for case in cases):
        found_by = [(r.repair.candidate, r.repair.used) for r in recordings]
        ranges = each(range_matches, cases, scales, *zip(*found_by, strict=True))
    estimated_from = [
        Recording(r.found, r.case.rig, prior, r.theta, some, r.windows, r.case.images.view)
        for r, prior, some in zip(recordings, _priors(recordings, free), ranges, strict=True)
    ]
    tolerances = recordings[0].repair.settings.tolerances
    kept, fits = _of_one_calibration(each(fitted, estimated_from))
    if not kept:
        return []
    recordings, estimated_from = [recordings[index] for index in kept], [estimated_from[index] for index in kept]
    estimates = [fit.alone.judged_by(tolerances.matters) for fit in fits]
    likely = with_free_together(estimates, free.names)
    again = each(matched_again, [r.case for r in recordings], [r.scale for r in recordings], likely)
    for index, (r, found, theta) in enumerate(zip(recordings, again, likely, strict=True)):
        used = without_frames_of(found, r.excluded)
        read = used if used.found >= ENOUGH.matches else r.found
        estimated_from[index] = replace(estimated_from[index], found=read, start=theta)
    fits = fitted_together(each(most_probable, beside_others(estimated_from, fits)))
    estimates = [one.judged_by(tolerances.matters) for one in each(Fit.weighed, fits)]
    decisions = decide_together(estimates, free.names, tolerances)
    several = zip(recordings, estimated_from, estimates, decisions, strict=True)
    return [Member(r, data.found, estimated, decision) for r, data, estimated, decision in several]


def _of_one_calibration(alone: Sequence[Fit]) -> tuple[list[int], list[Fit]]:
    """The fits together of those that show one calibration, and their numbers, without what agrees least, one by one
    (of many, a few at a time), until all agree; none, where too many differ to say which of them do."""
    kept = list(range(len(alone)))
    while len(kept) >= max((1.0 - MOST_EXCLUDED) * len(alone), 2):
        some = [alone[index] for index in kept]
        together = fitted_together(some)
        likelier = agreement(some, together)
        if likelier.min() > -NEGLIGIBLE:
            return kept, together
        worst = np.argsort(likelier)[: max(1, len(kept) // 16)]
        apart = {int(place) for place in worst if likelier[place] <= -NEGLIGIBLE}
        kept = [index for place, index in enumerate(kept) if place not in apart]
    return [], []


def _priors(recordings: Sequence[RepairedRecording], free: Parameters) -> list[Mixture]:
    """The prior of each recording of a joint estimate: the saved one of its calibration, or the common one."""
    ranges, common, found = any(r.case.ranges or r.windows.measured for r in recordings), None, []
    for repair in (recording.repair for recording in recordings):
        prior = None if repair.prior_use is None else repair.prior_use.prior
        known = common
        if known is None or isinstance(prior, SavedPrior):
            known = prior_of(prior, free, repair.initial, repair.settings.reach, ranges=ranges)
            known = as_prior(known, rig_parameters(repair.initial))
        if not isinstance(prior, SavedPrior):
            common = known
        found.append(known)
    return found


def solve_jointly(recordings: Sequence[RepairedRecording], free: Parameters, each: Each) -> tuple[Solution, ...]:
    """The repairs with what the recordings share estimated together, or, where that is not taken, as they were; `each`
    runs a task for each recording."""
    usable = [recording for recording in recordings if recording.usable]
    if len(usable) < 2:
        return tuple(recording.repair for recording in recordings)
    members = joint_estimate(usable, free, each)
    answers = _answers(members, free, each)
    shared, length = _shared(members, answers, free), _measured_length(members, answers, free)
    joint = {
        id(member.recording): _in_joint_solution(member, answer, shared, length)
        for member, answer in zip(members, answers, strict=True)
    }
    return tuple(
        joint.get(id(recording))
        or _apart(recording.repair, shared, Reason.FRAMES_DISAGREE if recording.usable else recording.repair.reason)
        for recording in recordings
    )


def _in_joint_solution(member: Member, answer: Solution, shared: Intrinsics | None, length: float | None) -> Solution:
    """The answer of a recording with the shared parameters; where it is good without, with no more than the length of
    the baseline that others tell; else its own repair."""
    if answer.accepted:
        return replace(answer, intrinsics=shared)
    if not answer.healthy:
        return _apart(member.recording.repair, shared, answer.reason)
    if length is not None and not member.estimate.matched_ranges:
        return _scaled(answer, length, shared)
    return replace(answer, intrinsics=shared and shared.not_applied(answer.reason))


def _answers(members: Sequence[Member], free: Parameters, each: Each) -> list[Solution]:
    """The solutions with the shared parameters taken, or found and not taken."""
    every = each(counted, [one.recording.case for one in members], [one.rig for one in members])
    answers = []
    for member, counts_of_all in zip(members, every, strict=True):
        repair, estimated, found, rig = member.recording.repair, member.estimate, member.found, member.rig
        given, matched_ranges = len(member.recording.case.ranges), estimated.matched_ranges
        tiles = counts_of_all[:, list(repair.used)]
        disagree = len(estimated.other_rigs) > MOST_EXCLUDED * len(repair.used)
        shown, reach = repair.seen or Seen(), repair.settings.reach
        seen = with_candidate(shown, found, estimated, rig, tiles, reach, frames_disagree=disagree)
        reason = reason_of(member.decision, seen)
        of_others = (one.recording.repair.used_images for one in members if one is not member)
        answer = replace(
            repair,
            candidate=rig,
            reason=reason,
            score_after=Score(int(tiles[1].sum()), repair.score_before.pixels),
            stages=with_found(repair.stages, found),
            estimate=estimated,
            decision=member.decision,
            seen=seen,
            ranges=RangesSeen.of(given, matched_ranges, repair.initial, rig, reason),
            settings=replace(repair.settings, free=free),
            prior_use=repair.prior_use and replace(repair.prior_use, other_images=tuple(chain(*of_others))),
        )
        answers.append(answer)
    return answers


def _shared(members: Sequence[Member], answers: Sequence[Solution], free: Parameters) -> Intrinsics | None:
    """The shared parameters, and whether any recording takes them; None, where no recordings have any."""
    if not members:
        return None
    first, taken = members[0], any(one.accepted for one in answers)
    outcome = IntrinsicsOutcome.REFINED if taken else IntrinsicsOutcome.REFUSED
    refused = None if taken else answers[0].reason
    return intrinsics_of(first.estimate, first.decision.theta, free.shared, outcome, refused)


def _apart(own: Solution, shared: Intrinsics | None, why: Reason) -> Solution:
    """A repair that does not take the shared parameters: with its own, if it has some."""
    if own.intrinsics is not None:
        return replace(own, intrinsics=replace(own.intrinsics, outcome=IntrinsicsOutcome.APART, refused=why))
    return replace(own, intrinsics=shared and shared.not_applied(why))


def _measured_length(members: Sequence[Member], answers: Sequence[Solution], free: Parameters) -> float | None:
    """How many times as long as given the baseline is, by ranges or motion; None, where nothing tells."""
    for member, answer in zip(members, answers, strict=True) if BASELINE in free.names else ():
        measured = member.estimate.matched_ranges.agree(answer.rig) or member.recording.windows.measured
        if answer.accepted and measured:
            return float(answer.candidate.extrinsics[3] / answer.initial.extrinsics[3])
    return None


def _scaled(good: Solution, length: float, shared: Intrinsics | None) -> Solution:
    """What stays where rows are good, with the length of the baseline that other recordings tell: rows are the same."""
    extrinsics = np.array(good.initial.extrinsics, float)
    extrinsics[3:] *= length
    candidate = good.initial.with_extrinsics(extrinsics)
    assert good.decision is not None
    rows, view = good.decision.rows_px[[0, 0]], good.decision.view_px[[0, 0]]
    return replace(
        good,
        candidate=candidate,
        reason=Reason.IMPROVED,
        intrinsics=shared and shared.of((BASELINE,)),
        decision=replace(good.decision, rows_px=rows, view_px=view),
        score_after=good.score_before,
    )
