"""Repairs that share intrinsics or the length of the baseline: from repairs of the extrinsics to one estimate
of all parameters."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereorecal.decision import Reason
from stereorecal.estimation import Each, with_free_together
from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, Parameters, row_chart
from stereorecal.recalibration._freed_intrinsics import Intrinsics, IntrinsicsOutcome, intrinsics_of
from stereorecal.recalibration._joint_estimate import JointEstimate, joint_estimate
from stereorecal.recalibration._match_ranges import RangesSeen
from stereorecal.recalibration._regional_misfit import misfit
from stereorecal.recalibration._repaired_recording import RepairedRecording
from stereorecal.recalibration._row_residuals import TILES_OF_A_FRAME, places_of
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._uncertainty import uncertainty_of
from stereorecal.recalibration._worker_tasks import counted
from stereorecal.scoring.host import Score


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
