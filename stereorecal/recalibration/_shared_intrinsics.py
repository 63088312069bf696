"""Repairs that share intrinsics or the length of the baseline: from repairs of the extrinsics to one estimate of all
parameters.

Repaired recordings are matched, ranged and counted in workers, each solved beside the others, matched again and solved
again; then one decision is taken for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import ENOUGH, Decision, Reason, Seen, Tolerances, decide_together, reason_of
from stereorecal.estimation import (
    NO_RANGES,
    NO_WINDOWS,
    CalibrationPrior,
    Each,
    Earlier,
    Estimate,
    MatchedRanges,
    Recording,
    SavedPrior,
    Windows,
    as_prior,
    estimate_together,
    rig_parameters,
    with_free_together,
)
from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, row_chart
from stereorecal.recalibration._assessment import MOST_EXCLUDED, share_lost, turned_by
from stereorecal.recalibration._match_ranges import RangesSeen, match_ranges
from stereorecal.recalibration._prior_use import prior_of
from stereorecal.recalibration._row_residuals import TILES_OF_A_FRAME, RowResiduals, misfit, places_of, row_residuals
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._uncertainty import Intrinsics, IntrinsicsOutcome, intrinsics_of, uncertainty_of
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import Correspondences, pyramid, with_rays_of
from stereorecal.scoring.host import Score, correspondences, counts_by_tile

_UNUSABLE = (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES)


@dataclass(frozen=True, eq=False)
class MatchTask:
    """Pairs to look at through rigs: no more than a worker needs travels to it.

    Attributes:
        scale: at which they are matched.
    """

    rigs: tuple[StereoRig, ...]
    pairs: tuple[Pair, ...]
    view: View
    matcher: AbstractMatcher
    scale: float
    ranges: tuple[Range, ...] = ()


def matched(task: MatchTask) -> Correspondences:
    """The correspondences under the first rig."""
    rig = task.rigs[0]
    data = pyramid(rig, task.pairs, task.view).at(task.scale)
    return correspondences(data, with_unit_baseline(rig.extrinsics), task.matcher)


def range_matches(task: MatchTask) -> MatchedRanges:
    """The ranges, matched under the first rig."""
    rig = task.rigs[0]
    return match_ranges(pyramid(rig, task.pairs, task.view).at(task.scale), rig, task.matcher, task.pairs, task.ranges)


def counted(task: MatchTask) -> Int[np.ndarray, "rigs k tiles"]:
    """Counts of the tiles of all frames at full scale, under each rig."""
    return np.stack(
        [
            counts_by_tile(
                pyramid(rig, task.pairs, task.view).at(1.0), with_unit_baseline(rig.extrinsics)[None], task.matcher
            )[0]
            for rig in task.rigs
        ]
    )


@dataclass(frozen=True, eq=False)
class RepairedRecording:
    """Pairs, the repair of their rig's extrinsics with the intrinsics as they were, and ranges of what they show; the
    frames that the repair left out take no part.
    """

    pairs: tuple[Pair, ...]
    repair: Solution
    ranges: tuple[Range, ...] = ()

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
    def kept(self) -> tuple[Pair, ...]:
        """The pairs that it rests on."""
        return tuple(self.pairs[index] for index in self.repair.used)

    @property
    def windows(self) -> Windows:
        """Of the kept pairs that follow each other, numbered as these."""
        estimate = self.repair.estimate
        return NO_WINDOWS if estimate is None else estimate.windows.numbered(self.repair.used)

    def usable(self, *, intrinsics_free: bool) -> bool:
        """Whether it can take part. Frames may disagree by intrinsics that are free; that is judged at the end."""
        found, reason = self.repair.found, self.repair.reason
        if reason in _UNUSABLE or (reason is Reason.FRAMES_DISAGREE and not intrinsics_free):
            return False
        return found is not None and found.found >= ENOUGH.matches

    def task(self, *rigs: StereoRig, ranges: bool = False) -> MatchTask:
        """To look at the kept pairs through rigs, as the repair looked at them."""
        repair, own = self.repair, self.ranges if ranges else ()
        return MatchTask(rigs, self.kept, repair.view, repair.matcher, repair.stages[-1].scale, own)


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


def solve_jointly(recordings: Sequence[RepairedRecording], free: Parameters, each: Each) -> tuple[Solution, ...]:
    """The repairs with what the recordings share freed as well, or, where that is not taken, as they were. Ranges say
    how long the baseline is, whether intrinsics are taken or not.

    Args:
        each: runs a task for each recording.
    """
    intrinsics_free = bool(free.intrinsics)
    part = [recording for recording in recordings if recording.usable(intrinsics_free=intrinsics_free)]
    if not part:
        return tuple(_unsolved(recording, free) for recording in recordings)
    solved = joint_estimate(part, free, each)
    answers, intrinsics = _answers(solved, each), None
    if solved.free.intrinsics:
        intrinsics = _intrinsics(solved, answers)
        if not intrinsics.taken:
            solutions = _with_intrinsics_held(recordings, free, each)
            return tuple(replace(solution, intrinsics=intrinsics) for solution in solutions)
    results = iter(_solutions(solved, answers, intrinsics))
    return tuple(
        next(results)
        if r.usable(intrinsics_free=intrinsics_free)
        else replace(r.repair, intrinsics=intrinsics and intrinsics.not_applied(r.repair.reason), ranges=_unmatched(r))
        for r in recordings
    )


def _with_intrinsics_held(
    recordings: Sequence[RepairedRecording], free: Parameters, each: Each
) -> tuple[Solution, ...]:
    held = _held(free)
    if held.shared:
        return solve_jointly(recordings, held, each)
    return tuple(recording.repair for recording in recordings)


def _held(free: Parameters) -> Parameters:
    """The free parameters without intrinsics."""
    return Parameters(tuple(name for name in free.names if "." not in name), free.priors)


def _answers(solved: JointEstimate, each: Each) -> list[Solution]:
    """With the shared parameters taken, or found and not taken."""
    recordings = solved.recordings
    rigs = [solved.rig(index) for index in range(len(recordings))]
    counts = each(counted, [r.task(r.repair.initial, g) for g, r in zip(rigs, recordings, strict=True)])
    found = []
    for index, (rig, recording, tiles) in enumerate(zip(rigs, recordings, counts, strict=True)):
        repair, reason = recording.repair, solved.reason(index, tiles)
        estimated, decision = solved.estimates[index], solved.decisions[index]
        rows = solved.rows(index, decision.theta)
        solution = replace(
            repair,
            candidate=rig,
            reason=reason,
            score_after=Score(int(tiles[1].sum()), repair.score_before.pixels),
            row_errors=rows.errors,
            misfit=misfit(rows, late=estimated.is_late),
            uncertainty=uncertainty_of(estimated, rig, row_chart(repair.initial, repair.settings.reach, solved.free)),
            estimate=estimated,
            decision=decision,
            ranges=_range_report(solved, index, rig, reason),
            disagreeing=repair.disagreeing if reason is Reason.FRAMES_DISAGREE else (),
            settings=replace(repair.settings, free=solved.free),
            prior_use=repair.prior_use and replace(repair.prior_use, other_images=_images_of_others(recordings, index)),
        )
        found.append(solution)
    return found


def _images_of_others(recordings: Sequence[RepairedRecording], index: int) -> tuple[str, ...]:
    """Fingerprints of the pairs that the other recordings rest on."""
    return tuple(
        image for at, recording in enumerate(recordings) if at != index for image in recording.repair.used_images
    )


def _intrinsics(solved: JointEstimate, answers: Sequence[Solution]) -> Intrinsics:
    """The shared parameters, and whether they are taken."""
    free, decisions = solved.free, solved.decisions
    held = with_free_together(solved.estimates, _held(free).names)
    outcome = IntrinsicsOutcome.REFINED if any(one.accepted for one in answers) else IntrinsicsOutcome.REFUSED
    fixed, freed = (
        float(np.mean([solved.rows(at, theta).errors.after for at, theta in enumerate(thetas)]))
        for thetas in (held, [one.theta for one in decisions])
    )
    places = np.unique(np.concatenate([places_of(one.found) for one in solved.estimated_from]))
    expected = [
        estimated.row_error_px(one.theta)[10][0] for estimated, one in zip(solved.estimates, decisions, strict=True)
    ]
    return intrinsics_of(
        solved.estimates[0],
        decisions[0].theta,
        free.shared,
        outcome,
        fixed_px=fixed,
        freed_px=freed,
        shown=len(places) / TILES_OF_A_FRAME,
        expected_px=min(expected),
        refused=answers[0].reason if outcome is IntrinsicsOutcome.REFUSED else None,
    )


def _solutions(solved: JointEstimate, answers: Sequence[Solution], intrinsics: Intrinsics | None) -> list[Solution]:
    """Of each recording: what was found together, or what it has alone, with no more than the length of the baseline
    that the ranges of others tell."""
    baseline_measured = BASELINE in solved.free.names and any(
        answer.accepted and (some.agree(answer.rig) or recording.windows.measured)
        for answer, some, recording in zip(answers, solved.ranges, solved.recordings, strict=True)
    )
    found = []
    for index, answer in enumerate(answers):
        if answer.accepted or not solved.free.shared:
            found.append(replace(answer, intrinsics=intrinsics))
            continue
        own = solved.recordings[index].repair
        scaled = baseline_measured and own.reason.healthy and not solved.ranges[index]
        own = _scaled(own, answer) if scaled else own
        of_ranges = _range_report(solved, index, own.rig, answer.reason)
        own_intrinsics = intrinsics and intrinsics.not_applied(answer.reason)
        found.append(replace(own, intrinsics=own_intrinsics, ranges=of_ranges))
    return found


def _scaled(solution: Solution, found: Solution) -> Solution:
    """A repair, or what stays where it was not needed, with the length of the baseline that other recordings tell: rows
    are the same."""
    extrinsics = np.array(solution.rig.extrinsics, float)
    extrinsics[3:] *= _length(found.candidate) / _length(found.initial)
    return replace(
        solution,
        uncertainty=found.uncertainty,
        estimate=found.estimate,
        candidate=solution.rig.with_extrinsics(extrinsics),
        reason=Reason.IMPROVED,
        settings=replace(solution.settings, free=found.settings.free),
    )


def _length(rig: StereoRig) -> float:
    return abs(float(rig.extrinsics[3]))  # what only a change of the length moves


def _range_report(solved: JointEstimate, index: int, used: StereoRig, reason: Reason) -> RangesSeen | None:
    """What became of the ranges of a recording, with the rig to use."""
    estimated, found, given = solved.estimates[index], solved.rig(index), len(solved.recordings[index].ranges)
    report = RangesSeen.of(given, estimated.matched_ranges, estimated.chart.rig, found, reason)
    return report and replace(report, contradict=int(estimated.matched_ranges.contradict(used).sum()))


def _unsolved(recording: RepairedRecording, free: Parameters) -> Solution:
    """The repair of a recording where nothing that is shared could be solved for."""
    intrinsics = _not_solved(recording.repair, free) if free.intrinsics else None
    return replace(recording.repair, intrinsics=intrinsics, ranges=_unmatched(recording))


def _unmatched(recording: RepairedRecording) -> RangesSeen | None:
    """What became of the ranges of a recording that took no part."""
    return RangesSeen(len(recording.ranges), 0, 0) if recording.ranges else None


def _not_solved(repair: Solution, free: Parameters) -> Intrinsics:
    parameters = [one for one in free.of(repair.initial, repair.settings.reach) if one.name in free.shared]
    missing = np.full(len(parameters), np.nan)
    names, units = tuple(one.name for one in parameters), tuple(one.unit for one in parameters)
    nan = float("nan")
    return Intrinsics(IntrinsicsOutcome.NOT_SOLVED, names, units, missing, missing, names, nan, nan, 0.0, nan)
