"""Repairs that share intrinsics or the length of the baseline: from repairs of the extrinsics to one estimate
of all parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from stereorecal.estimation import NO_BEAMS, Prior
from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, Parameters, row_chart
from stereorecal.recalibration._acceptance import Reason, Verdict, behind
from stereorecal.recalibration._common import Common, common
from stereorecal.recalibration._estimated import uncertainty_of
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME
from stereorecal.recalibration._intrinsics import Intrinsics, IntrinsicsOutcome
from stereorecal.recalibration._ranges import RangesSeen
from stereorecal.recalibration._recording import Recording
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._tasks import Each, counted
from stereorecal.recalibration._uncertainty import OBSERVED
from stereorecal.scoring.host import Score

_GAIN = 0.5  # probability that the intrinsics as they were are worse


def together(
    recordings: Sequence[Recording], free: Parameters, prior: Prior, *, one: bool, each: Each
) -> tuple[Solution, ...]:
    """The repairs with what the recordings share freed as well, or, where that is not taken, as they were. Ranges say
    how long the baseline is, whether intrinsics are taken or not.

    Args:
        one: all recordings have the same extrinsics.
        each: runs a task for each recording.
    """
    lenses = bool(free.lenses)
    part = [recording for recording in recordings if recording.usable(lenses=lenses)]
    if not part:
        return tuple(_unsolved(recording, free) for recording in recordings)
    solved = common(part, free, prior, one=one, each=each)
    answers, seen = _answers(solved, each), None
    if lenses:
        seen = _intrinsics(solved, answers)
        if not seen.taken:
            rest = _without_lenses(recordings, free, prior, one=one, each=each)
            return tuple(replace(solution, intrinsics=seen) for solution in rest)
    results = iter(_solutions(solved, answers, prior, seen, each))
    return tuple(
        next(results)
        if r.usable(lenses=lenses)
        else replace(r.repair, intrinsics=seen and seen.not_here(r.repair.reason), ranges=_unmatched(r))
        for r in recordings
    )


def _without_lenses(
    recordings: Sequence[Recording], free: Parameters, prior: Prior, *, one: bool, each: Each
) -> tuple[Solution, ...]:
    rest = Parameters(tuple(name for name in free.names if "." not in name), free.priors)
    if rest.shared or (one and len(recordings) > 1):
        return together(recordings, rest, prior, one=one, each=each)
    return tuple(recording.repair for recording in recordings)


@dataclass(frozen=True, eq=False)
class _Answer:
    """What is said of one recording.

    Attributes:
        solution: with the shared parameters taken, or found and not taken.
        verdict: on it.
    """

    solution: Solution
    verdict: Verdict


def _answers(solved: Common, each: Each) -> list[_Answer]:
    """One for each recording; where all have the same extrinsics, with one verdict."""
    recordings = solved.recordings
    rigs = [solved.rig(index) for index in range(len(recordings))]
    counts = each(counted, [r.task(r.repair.initial, r.repair.rig, g) for g, r in zip(rigs, recordings, strict=True)])
    joined = [np.concatenate(counts, axis=1)] if solved.one else counts
    verdicts = [solved.verdict(at, tiles[[0, 2]]) for at, tiles in enumerate(joined)]
    found = []
    for index, (rig, recording, tiles) in enumerate(zip(rigs, recordings, counts, strict=True)):
        repair, (said, rows, left) = recording.repair, verdicts[solved.of(index)]
        seen = solved.estimates[solved.of(index)]
        if said.reason.accepted and not solved.one and _falls_behind(repair, solved, tiles, rows.after):
            said = Verdict(Reason.ALREADY_GOOD, Reason.WORSE_ON_HELD_OUT)
        accepted = said.reason.accepted
        solution = replace(
            repair,
            rig=rig if accepted else repair.initial,
            candidate=rig,
            accepted=accepted,
            reason=said.reason,
            score_after=Score(int(tiles[2].sum()), repair.score_before.pixels),
            row_errors=rows,
            misfit=left,
            uncertainty=uncertainty_of(seen, rig, row_chart(repair.initial, repair.reach, solved.free)),
            free=solved.free,
            estimate=seen,
            beams=seen.beams,
            ranges=_ranges(solved, index, rig, said),
            disagreeing=repair.disagreeing if said.reason is Reason.FRAMES_DISAGREE else (),
        )
        found.append(_Answer(solution, said))
    return found


def _falls_behind(repair: Solution, solved: Common, counts: Int[np.ndarray, "3 k tiles"], rows_px: float) -> bool:
    """Whether a recording was better off with what it had alone; those that share their extrinsics must bear what
    another one asks for."""
    if not repair.accepted or repair.row_errors is None:
        return False
    _, alone, here = counts.sum(axis=(1, 2)).tolist()
    scale = float(solved.shown[0].found.scale)
    return behind(alone, here, scale * repair.row_errors.after, scale * rows_px)


def _intrinsics(solved: Common, answers: Sequence[_Answer]) -> Intrinsics:
    """The shared parameters, and whether they are taken."""
    seen, free = solved.estimates[0], solved.free
    where = [seen.names.index(name) for name in free.shared]
    held, freed = (
        float(np.mean([solved.facts(at, some)[1].after for at in range(len(solved.shown))]))
        for some in (free.extrinsics, free)
    )
    gains = [
        one.probability_worse(one.with_free(free.axes), than=theta)
        for one, theta in zip(solved.estimates, solved.thetas, strict=True)
    ]
    taken = [answer for answer in answers if answer.solution.accepted]
    outcome = IntrinsicsOutcome.REFINED if taken else IntrinsicsOutcome.REFUSED
    outcome = outcome if max(gains) > _GAIN else IntrinsicsOutcome.NO_GAIN
    low, high = seen.intervals[where].T
    tiles = [np.asarray(one.found.tile)[np.asarray(one.found.weight) > 0] % TILES_OF_A_FRAME for one in solved.shown]
    spread = np.diag(seen.posterior.covariance)[where]
    expects = [one.row_error_px(theta)[10][0] for one, theta in zip(solved.estimates, solved.thetas, strict=True)]
    return Intrinsics(
        outcome=outcome,
        names=free.shared,
        units=tuple(seen.units[index] for index in where),
        change=solved.thetas[0][where],
        interval=0.5 * (high - low),
        undetermined=tuple(
            name
            for name, now, given in zip(free.shared, spread, seen.prior_variance[where], strict=True)
            if now > OBSERVED**2 * given
        ),
        fixed_px=held,
        freed_px=freed,
        fixed_elsewhere_px=float("nan"),
        freed_elsewhere_px=float("nan"),
        shown=len(np.unique(np.concatenate(tiles))) / TILES_OF_A_FRAME,
        expected_px=min(expects),
        refused=answers[0].verdict.why if outcome is IntrinsicsOutcome.REFUSED else None,
    )


def _solutions(
    solved: Common, answers: Sequence[_Answer], prior: Prior, seen: Intrinsics | None, each: Each
) -> list[Solution]:
    """Of each recording: what was found together, or what it has alone, with no more than the length of the baseline
    that the ranges of others tell."""
    told = BASELINE in solved.free.names and any(
        answer.solution.accepted and some.agree(answer.solution.rig)
        for answer, some in zip(answers, solved.beams, strict=True)
    )
    if solved.one and solved.free.shared and not answers[0].solution.accepted:
        rest = [replace(recording, ranges=()) for recording in solved.recordings]
        alone = together(rest, solved.free.extrinsics, prior, one=True, each=each)
    else:
        alone = tuple(recording.repair for recording in solved.recordings)
    found = []
    for index, answer in enumerate(answers):
        if answer.solution.accepted or not solved.free.shared:
            found.append(replace(answer.solution, intrinsics=seen))
            continue
        scaled = told and alone[index].reason.healthy and not solved.beams[index]
        own = _scaled(alone[index], answer.solution) if scaled else alone[index]
        of_ranges = _ranges(solved, index, own.rig, answer.verdict)
        beams = NO_BEAMS if of_ranges is None else answer.solution.beams
        here = seen and seen.not_here(answer.verdict.why)
        found.append(replace(own, intrinsics=here, ranges=of_ranges, beams=beams))
    return found


def _scaled(solution: Solution, found: Solution) -> Solution:
    """A repair, or what stays where it was not needed, with the length of the baseline that other recordings tell: rows
    are the same."""
    extrinsics = np.array(solution.rig.extrinsics, float)
    extrinsics[3:] *= _length(found.candidate) / _length(found.initial)
    rig = solution.rig.with_extrinsics(extrinsics)
    reason = Reason.IMPROVED if solution.accepted else Reason.RANGES
    return replace(
        solution,
        rig=rig,
        candidate=rig,
        accepted=True,
        reason=reason,
        uncertainty=found.uncertainty,
        free=found.free,
        estimate=found.estimate,
    )


def _length(rig: StereoRig) -> float:
    return abs(float(rig.extrinsics[3]))  # what only a change of the length moves


def _ranges(solved: Common, index: int, used: StereoRig, said: Verdict) -> RangesSeen | None:
    """What became of the ranges of a recording, or of all where they have the same extrinsics."""
    recordings = solved.recordings if solved.one else [solved.recordings[index]]
    given = sum(len(recording.ranges) for recording in recordings)
    seen, at = solved.estimates[solved.of(index)], solved.of(index)
    found = seen.chart.rig_at(solved.thetas[at])
    if not given:
        return None
    refused = None if said.reason.accepted or not seen.beams.fit_better(seen.chart.rig, found) else said.why
    return RangesSeen(given, len(seen.beams.metres), int(seen.beams.contradict(used).sum()), refused)


def _unsolved(recording: Recording, free: Parameters) -> Solution:
    """The repair of a recording where nothing that is shared could be solved for."""
    seen = _not_solved(recording.repair, free) if free.lenses else None
    return replace(recording.repair, intrinsics=seen, ranges=_unmatched(recording))


def _unmatched(recording: Recording) -> RangesSeen | None:
    """What became of the ranges of a recording that took no part."""
    return RangesSeen(len(recording.ranges), 0, 0) if recording.ranges else None


def _not_solved(repair: Solution, free: Parameters) -> Intrinsics:
    parameters = [one for one in free.of(repair.initial, repair.reach) if one.name in free.shared]
    missing = np.full(len(parameters), np.nan)
    names, units = tuple(one.name for one in parameters), tuple(one.unit for one in parameters)
    nan = float("nan")
    return Intrinsics(IntrinsicsOutcome.NOT_SOLVED, names, units, missing, missing, names, nan, nan, nan, nan, 0.0, nan)
