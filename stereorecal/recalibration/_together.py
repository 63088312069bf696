"""Repairs of one rig that share intrinsics: from repairs of the extrinsics to one solution of all parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, Parameters
from stereorecal.recalibration._acceptance import Reason, Verdict, behind, implausible, regions_worse
from stereorecal.recalibration._intrinsics import MOST_WORSE, Intrinsics, IntrinsicsOutcome
from stereorecal.recalibration._misfit import Misfit
from stereorecal.recalibration._ranges import NONE, Beams, RangesSeen
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solved import Recording, Solved
from stereorecal.recalibration._tasks import Each, counted
from stereorecal.scoring.host import Score


def together(recordings: Sequence[Recording], free: Parameters, *, one: bool, each: Each) -> tuple[Solution, ...]:
    """The repairs with what the recordings share freed as well, or, where that is not taken, as they were. Ranges say
    how long the baseline is, whether intrinsics are taken or not.

    Args:
        one: all recordings have the same extrinsics.
        each: runs a task for each recording.
    """
    lenses = bool(free.lenses)
    taking_part = [recording for recording in recordings if recording.usable(lenses=lenses)]
    if not taking_part:
        return tuple(unsolved(recording, free) for recording in recordings)
    solved, seen, answers = Solved.of(taking_part, free, one=one, each=each), None, None
    if lenses:
        seen = solved.judged()
        answers = _answers(solved, each) if seen.taken else []
        if answers and not any(answer.taken for answer in answers):
            seen = replace(seen, outcome=IntrinsicsOutcome.REFUSED, refused=answers[0].verdict.why)
        if not seen.taken:
            found = _without_lenses(recordings, free, one=one, each=each)
            return tuple(replace(solution, intrinsics=seen) for solution in found)

    def alone() -> tuple[Solution, ...]:
        """What the recordings are left with where nothing is shared but, if so, the extrinsics."""
        if solved.one and free.shared:
            bare = [replace(recording, ranges=()) for recording in taking_part]
            return together(bare, free.extrinsics, one=True, each=each)
        return tuple(recording.repair for recording in taking_part)

    results = iter(_solutions(solved, answers or _answers(solved, each), seen, alone))
    return tuple(
        next(results)
        if r.usable(lenses=lenses)
        else replace(r.repair, intrinsics=seen and seen.not_here(r.repair.reason), ranges=_unused(r))
        for r in recordings
    )


def _without_lenses(
    recordings: Sequence[Recording], free: Parameters, *, one: bool, each: Each
) -> tuple[Solution, ...]:
    rest = Parameters(tuple(name for name in free.names if "." not in name), free.priors)
    if rest.shared or (one and len(recordings) > 1):
        return together(recordings, rest, one=one, each=each)
    return tuple(recording.repair for recording in recordings)


@dataclass(frozen=True, eq=False)
class _Answer:
    """What is said of one recording.

    Attributes:
        solution: with the shared parameters taken, or found and not taken.
        verdict: on it.
        ranged: its own ranges vouch for the length of the baseline.
    """

    solution: Solution
    verdict: Verdict
    ranged: bool

    @property
    def taken(self) -> bool:
        """It replaces the initial calibration."""
        return self.solution.accepted


def _answers(solved: Solved, each: Each) -> list[_Answer]:
    """One for each recording; where there is one member for all, with one verdict."""
    rigs, recordings = solved.rigs, solved.recordings
    tasks = [
        replace(r.task(r.repair.initial, r.repair.rig, rig), ranges=()) for rig, r in zip(rigs, recordings, strict=True)
    ]
    counts = each(counted, tasks)
    joined = [np.concatenate(counts, axis=1)] * len(counts) if solved.one else counts
    verdicts = [solved.verdict(index, tiles[[0, 2]]) for index, tiles in enumerate(joined[: len(solved.members)])]
    found = []
    for index, (rig, recording, tiles) in enumerate(zip(rigs, recordings, counts, strict=True)):
        repair, member = recording.repair, solved.member(index)
        said, rows, left = verdicts[0 if solved.one else index]
        ranged = bool(member.beams) and member.beams.agree(rig)
        said = _with_ranges(said, solved, index, left) if ranged else said
        if said.reason.accepted and _falls_behind(solved, index, tiles, rows.after):
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
            uncertainty=solved.uncertainty(index),
            free=solved.free,
            beams=member.beams,
            disagreeing=repair.disagreeing if said.reason is Reason.FRAMES_DISAGREE else (),
        )
        found.append(_Answer(solution, said, ranged=ranged))
    return found


def _with_ranges(said: Verdict, solved: Solved, index: int, left: Misfit) -> Verdict:
    """The verdict on a recording whose own ranges agree with the solution: where rows gain nothing, they may still tell
    that the calibration before was wrong, of a drift that is plausible and leaves no region worse."""
    member = solved.member(index)
    own = member.z[: solved.own]
    fits = said == Verdict(Reason.ALREADY_GOOD) and member.beams.fit_better(member.chart.rig, solved.rigs[index])
    harms = implausible(own, member.chart.prior) or regions_worse(left, solved.scale)
    return Verdict(Reason.RANGES) if fits and not harms else said


def _falls_behind(solved: Solved, index: int, counts: Int[np.ndarray, "3 k tiles"], rows_px: float) -> bool:
    """Whether a recording was better off with what it had alone: its repair, or the same rows with the intrinsics as
    they were. Recordings that share their extrinsics must bear what another one asks for."""
    repair = solved.recordings[index].repair
    if solved.lenses and solved.worse[index] > MOST_WORSE:
        return True
    if solved.one or not repair.accepted or repair.row_errors is None:
        return False
    _, alone, here = counts.sum(axis=(1, 2)).tolist()
    return behind(alone, here, solved.scale * repair.row_errors.after, solved.scale * rows_px)


def _solutions(
    solved: Solved, answers: Sequence[_Answer], seen: Intrinsics | None, alone: Callable[[], tuple[Solution, ...]]
) -> list[Solution]:
    """Of each recording: what was found together, or what it has alone, with no more than the length of the baseline
    that the ranges of others tell."""
    any_ranges = any(some for some in solved.beams)
    told = not solved.lenses and any(answer.taken and answer.ranged for answer in answers)
    others: tuple[Solution, ...] | None = None
    found = []
    for index, answer in enumerate(answers):
        has = bool(solved.beams[index]) or (solved.one and any_ranges)
        joint = answer.taken and (has or not any_ranges or solved.lenses)
        longer = told and not has
        if joint or (not longer and _nothing_refused(answer, solved, index)):
            found.append(_with_range_counts(replace(answer.solution, intrinsics=seen), solved, index, None))
            continue
        others = others or alone()
        rest = others[index]
        if longer and rest.reason.healthy:
            rest = _scaled(rest, solved, index)
        refused = answer.verdict.why if has else None
        rest = replace(rest, intrinsics=seen and seen.not_here(answer.verdict.why))
        found.append(_with_range_counts(rest, solved, index, refused))
    return found


def _nothing_refused(answer: _Answer, solved: Solved, index: int) -> bool:
    """Whether the initial calibration stays because there is nothing to gain, here and alone."""
    if solved.one and not solved.free.shared:
        return True  # there is nothing else that they could have in common
    repair = solved.recordings[index].repair
    return answer.verdict == Verdict(Reason.ALREADY_GOOD) and repair.reason is Reason.ALREADY_GOOD and not solved.lenses


def _scaled(solution: Solution, solved: Solved, index: int) -> Solution:
    """A repair, or what stays where it was not needed, with the length of the baseline that other recordings tell: rows
    are the same."""
    member = solved.member(index)
    at = member.chart.names.index(BASELINE)
    rig = _longer(solution.rig, 1.0 + float(member.chart.units[at] * member.z[at]) / 100.0)
    return replace(
        solution,
        rig=rig,
        candidate=rig,
        accepted=True,
        reason=Reason.IMPROVED if solution.accepted else Reason.RANGES,
        uncertainty=solved.uncertainty(index),
        free=solved.free,
    )


def _longer(rig: StereoRig, times: float) -> StereoRig:
    extrinsics = np.array(rig.extrinsics, float)
    extrinsics[3:] *= times
    return rig.with_extrinsics(extrinsics)


def _with_range_counts(solution: Solution, solved: Solved, index: int, refused: Reason | None) -> Solution:
    """The solution with what became of the ranges, if there were any; those that mostly contradict it have no say in
    what is to be expected of it."""
    recordings = solved.recordings if solved.one else [solved.recordings[index]]
    given = sum(len(recording.ranges) for recording in recordings)
    if not given:
        return solution
    beams = Beams.of_all(solved.beams) if solved.one else solved.beams[index]
    seen = RangesSeen(given, len(beams.metres), int(beams.contradict(solution.rig).sum()), refused)
    return replace(solution, ranges=seen, beams=beams if beams and beams.agree(solution.rig) else NONE)


def unsolved(recording: Recording, free: Parameters) -> Solution:
    """The repair of a recording where nothing that is shared could be solved for."""
    seen = _not_solved(recording.repair, free) if free.lenses else None
    return replace(recording.repair, intrinsics=seen, ranges=_unused(recording))


def _unused(recording: Recording) -> RangesSeen | None:
    """What became of the ranges of a recording that took no part."""
    return RangesSeen(len(recording.ranges), 0, 0) if recording.ranges else None


def _not_solved(repair: Solution, free: Parameters) -> Intrinsics:
    parameters = [one for one in free.of(repair.initial, repair.reach) if one.name in free.shared]
    missing = np.full(len(parameters), np.nan)
    names, units = tuple(one.name for one in parameters), tuple(one.unit for one in parameters)
    nan = float("nan")
    return Intrinsics(IntrinsicsOutcome.NOT_SOLVED, names, units, missing, missing, names, nan, nan, nan, nan, 0.0, nan)
