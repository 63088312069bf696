"""Repairs of one rig that share intrinsics: from repairs of the extrinsics to one solution of all parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.objectives import BASELINE, Parameters, read_by, row_chart
from stereorecal.recalibration import _unseen
from stereorecal.recalibration._acceptance import Reason, RowErrors, compared, verdict
from stereorecal.recalibration._agreement import MOST_APART, disagreeing
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence, mean_by
from stereorecal.recalibration._expected import expected
from stereorecal.recalibration._intrinsics import Intrinsics, IntrinsicsOutcome, outcome
from stereorecal.recalibration._joint import Joint, Member, joint, solved_together
from stereorecal.recalibration._misfit import Misfit, chance, misfit
from stereorecal.recalibration._ranges import NONE, Beams, beams
from stereorecal.recalibration._schedule import Schedule, ScoreKind
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import FEWEST
from stereorecal.recalibration._uncertainty import NORMAL_95, OBSERVED, uncertainty
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import Correspondences, ScoringData, host, pyramid
from stereorecal.scoring.host import Score

_MATCHED_AGAIN = 1  # times, under the rig found so far: far from it, windows at the edges of the view meet other things
_FOLDS_OF_FRAMES = 4  # of one recording, for cross-validation
_WORSE = 0.05  # pixels
_CONTRADICTS = 3.0  # standard deviations of a range
_UNUSABLE = (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES)

Each = Callable[[Callable[[Any], Any], Sequence[Any]], Sequence[Any]]  # does one thing to many, somewhere


def one_by_one(function: Callable[[Any], Any], tasks: Sequence[Any]) -> Sequence[Any]:
    """Here, one task after the other."""
    return [function(task) for task in tasks]


def check_schedule(schedule: Schedule, free: Parameters) -> None:
    """Refuse to free what the count cannot see.

    Raises:
        InputError: if a schedule without rows is asked for intrinsics, the baseline or ranges.
    """
    if free.shared and schedule.stages[-1].score is not ScoreKind.EPIPOLAR:
        raise InputError(
            "the count sees neither intrinsics nor ranges; leave the default schedule, which ends on rows."
        )


@dataclass(frozen=True, eq=False)
class Recording:
    """Pairs, the repair of their rig's extrinsics with the intrinsics as they were, and ranges of what they show; the
    frames that the repair left out take no part.
    """

    pairs: tuple[Pair, ...]
    repair: Solution
    ranges: tuple[Range, ...] = ()

    @property
    def found(self) -> Correspondences | None:
        """The last correspondences of the repair."""
        return self.repair.found

    @property
    def kept(self) -> tuple[Pair, ...]:
        """The pairs that it rests on."""
        return tuple(self.pairs[index] for index in self.repair.kept)

    def usable(self, *, lenses: bool) -> bool:
        """Whether it can take part: where lenses are free, frames may disagree by theirs; that is judged at the end."""
        found, reason = self.found, self.repair.reason
        if reason in _UNUSABLE or (reason is Reason.FRAMES_DISAGREE and not lenses):
            return False
        return found is not None and found.found >= FEWEST

    def member(self, free: Parameters, of_ranges: Beams) -> Member:
        """With its own solution; the intrinsics are as they were.

        Raises:
            ValueError: if it is not usable.
        """
        if self.found is None:
            raise ValueError("a recording without correspondences has no part in a joint solution")
        chart = row_chart(self.repair.initial, self.repair.reach, free)
        return Member(chart, self.found, chart.coordinates(np.asarray(self.repair.candidate.extrinsics)), of_ranges)


def together(recordings: Sequence[Recording], free: Parameters, *, one: bool, each: Each) -> tuple[Solution, ...]:
    """The repairs with what the recordings share freed as well, or, where that is not taken, as they were. Ranges say
    how long the baseline is, whether intrinsics are taken or not.

    Args:
        one: all recordings have the same extrinsics.
        each: runs a task for each recording.
    """
    lenses = any("." in name for name in free.names)
    taking_part = [recording for recording in recordings if recording.usable(lenses=lenses)]
    if not taking_part:
        seen = _not_solved(recordings[0].repair, free) if lenses else None
        return tuple(replace(r.repair, intrinsics=seen) for r in recordings)
    solved, seen = _Solved.of(taking_part, free, one=one, each=each), None
    if lenses:
        seen = solved.judged()
        if not seen.taken:
            rest = Parameters(tuple(name for name in free.names if "." not in name), free.priors)
            found = together(recordings, rest, one=one, each=each) if rest.shared else [r.repair for r in recordings]
            return tuple(replace(solution, intrinsics=seen) for solution in found)
    results = iter(solved.solutions(seen, each))
    not_here = None if seen is None else seen.not_here
    return tuple(
        next(results) if r.usable(lenses=lenses) else replace(r.repair, intrinsics=not_here) for r in recordings
    )


@dataclass(frozen=True, eq=False)
class _Solved:
    """The common solution.

    Attributes:
        recordings: those that take part.
        members: one for each, or one for all.
        free: own and shared parameters.
    """

    recordings: Sequence[Recording]
    members: tuple[Member, ...]
    free: Parameters

    @property
    def own(self) -> int:
        return len(self.free.axes)

    @staticmethod
    def of(recordings: Sequence[Recording], free: Parameters, *, one: bool, each: Each) -> "_Solved":
        tasks = [_Task(r.repair.candidate, r.kept, r.repair, r.ranges) for r in recordings]
        of_ranges = each(_beams, tasks) if any(r.ranges for r in recordings) else [NONE] * len(recordings)
        members = tuple(r.member(free, some) for r, some in zip(recordings, of_ranges, strict=True))
        solved = _Solved(recordings, _merged(members) if one else members, free)._solved_again()
        for _ in range(_MATCHED_AGAIN):
            rigs = solved.rigs
            tasks = [_Task(rig, r.kept, r.repair) for rig, r in zip(rigs, recordings, strict=True)]
            matched = [
                read_by(found, taken=rig, rig=r.repair.initial) if found.found >= FEWEST else member.found
                for found, rig, r, member in zip(each(_matched, tasks), rigs, recordings, members, strict=True)
            ]
            members = tuple(
                replace(solved.member(index), found=found, beams=some)
                for index, (found, some) in enumerate(zip(matched, of_ranges, strict=True))
            )
            solved = replace(solved, members=_merged(members) if one else members)._solved_again()
        return solved

    @cached_property
    def problem(self) -> Joint:
        """At the solution."""
        return joint(self.members, self.own)

    @cached_property
    def facts(self) -> list[Evidence]:
        """Of each member, at the solution."""
        return [member.facts() for member in self.members]

    @cached_property
    def by_chance(self) -> Float[np.ndarray, "N N"]:
        """The covariance of all parameters, without the misfit."""
        return self.problem.covariance()

    @cached_property
    def by_misfit(self) -> Float[np.ndarray, "N N"]:
        """What the misfit adds to it."""
        return self.problem.by_misfit(_alike(self.facts))

    @cached_property
    def unseen(self) -> tuple[Float[np.ndarray, "t"], ...]:
        """Row errors of each member's tiles, by solutions that have not seen their place."""
        return _unseen.by_place(self.members, self.own)

    def _solved_again(self) -> "_Solved":
        return replace(self, members=solved_together(self.members, self.own))

    @property
    def rigs(self) -> list[StereoRig]:
        """Of each recording."""
        of_recordings = [self.member(index) for index in range(len(self.recordings))]
        return [member.chart.rig_at(member.z) for member in of_recordings]

    def member(self, index: int) -> Member:
        """Of a recording."""
        return self.members[0 if len(self.members) == 1 else index]

    def judged(self) -> Intrinsics:
        """The shared parameters, and whether they are taken."""
        chart, problem, facts = self.members[0].chart, self.problem, self.facts
        shared = slice(problem.size - chart.dim + self.own, None)
        fixed = self._fixed()
        before, after = _unseen.by_place(fixed, self.own), self.unseen
        gains = [f.by_place(b - a) for f, b, a in zip(facts, before, after, strict=True)]
        places = [np.unique(f.tile % TILES_OF_A_FRAME) for f in facts]
        gain = mean_by(np.concatenate(places), np.concatenate(gains))
        here, there = self._elsewhere(fixed), self._elsewhere(self.members)
        covariance = self.by_chance + self.by_misfit
        of_member = problem.where(0)
        spread = covariance[np.ix_(of_member, of_member)]
        rig, view = chart.rig_at(self.members[0].z), self.recordings[0].repair.view
        expects = expected(rig, chart, self.members[0].z, spread, view).rows_px
        scale = facts[0].scale
        worse = float(np.mean(scale * np.concatenate([a - b for b, a in zip(before, after, strict=True)]) > _WORSE))
        shown = len(np.unique(np.concatenate(places))) / TILES_OF_A_FRAME
        deviations = np.sqrt(np.diag(covariance)[shared])
        units = chart.units[self.own :]
        return Intrinsics(
            outcome=outcome(scale * gain, scale * (here - there), worse, shown, scale * expects),
            names=chart.names[self.own :],
            units=tuple(parameter.unit for parameter in chart.parameters[self.own :]),
            change=self.members[0].z[self.own :] * units,
            interval=NORMAL_95 * deviations * units,
            undetermined=tuple(
                name for name, d in zip(chart.names[self.own :], deviations, strict=True) if d > OBSERVED * chart.prior
            ),
            fixed_px=float(np.mean(np.concatenate(before))),
            freed_px=float(np.mean(np.concatenate(after))),
            fixed_elsewhere_px=here,
            freed_elsewhere_px=there,
            shown=shown,
            expected_px=expects,
        )

    def _fixed(self) -> tuple[Member, ...]:
        """The same correspondences under the extrinsics alone, the intrinsics as they were."""
        members = []
        for recording, member in zip(self.recordings, self.members, strict=False):
            chart = replace(member.chart, parameters=member.chart.parameters[: self.own])
            start = chart.coordinates(np.asarray(recording.repair.candidate.extrinsics))
            members.append(Member(chart, member.found, start, member.beams))
        return solved_together(members, self.own)

    def _elsewhere(self, members: tuple[Member, ...]) -> float:
        """Row error of what took no part; NaN where everything did."""
        if len(members) == 1:
            recording = self._of_frames()
            if recording.max() == 0:
                return float("nan")
        else:
            recording = np.arange(0)
        return float(np.mean(np.concatenate(_unseen.by_recording(members, self.own, recording))))

    def _of_frames(self) -> Int[np.ndarray, "f"]:
        """Which recording each frame belongs to, of one member; of one recording, which stretch of it."""
        if len(self.recordings) > 1:
            return np.repeat(np.arange(len(self.recordings)), [len(r.kept) for r in self.recordings])
        frames = len(self.recordings[0].kept)
        return np.arange(frames) * min(_FOLDS_OF_FRAMES, frames) // frames

    def solutions(self, seen: Intrinsics | None, each: Each) -> tuple[Solution, ...]:
        """Of each recording, with the shared parameters taken; where there is one member, one verdict for all."""
        tasks = [_Task(rig, r.kept, r.repair) for rig, r in zip(self.rigs, self.recordings, strict=True)]
        counts, one = each(_counted, tasks), len(self.members) == 1
        verdicts = [
            self._verdict(index, tiles)
            for index, tiles in enumerate([np.concatenate(counts, axis=1)] if one else counts)
        ]
        found = []
        for index, (task, tiles) in enumerate(zip(tasks, counts, strict=True)):
            at, repair = 0 if one else index, task.repair
            member, here = self.members[at], np.ix_(self.problem.where(at), self.problem.where(at))
            reason, rows, left = verdicts[at]
            found.append(
                replace(
                    repair,
                    rig=task.candidate if reason.accepted else repair.initial,
                    candidate=task.candidate,
                    accepted=reason.accepted,
                    reason=reason,
                    score_after=Score(int(tiles[1].sum()), repair.score_before.pixels),
                    row_errors=rows,
                    misfit=left,
                    uncertainty=uncertainty(self.by_chance[here], self.by_misfit[here], member.chart),
                    intrinsics=seen if seen is None or reason.accepted else seen.not_here,
                    free=self.free,
                    beams=member.beams,
                    disagreeing=repair.disagreeing if reason is Reason.FRAMES_DISAGREE else (),
                )
            )
        return tuple(found)

    def _verdict(self, at: int, tiles: Int[np.ndarray, "2 k tiles"]) -> tuple[Reason, RowErrors, Misfit]:
        """On a member, whose tiles have these counts before and after."""
        facts = self.facts[at]
        own, seen = facts.only(slice(self.own)), facts.only(np.array([name != BASELINE for name in self.free.names]))
        # Where lenses change, extrinsics follow along axes that rows hardly see, and every drift would be strange: what
        # vouches for those are rows that took no part.
        usual = 1.0 if any("." in name for name in self.free.names) else chance(seen)
        left = replace(misfit(own, *tiles), chance=usual)
        rows = compared(facts, facts.medians(facts.start_residual), self.unseen[at])
        reason = verdict(tiles.sum(axis=(1, 2)), rows, own, left, self.members[at].found.covered)
        if len(disagreeing(own)[0]) > MOST_APART * own.frames:
            reason = Reason.FRAMES_DISAGREE
        if reason is Reason.ALREADY_GOOD and any(_fits_ranges_better(member) for member in self.members):
            reason = Reason.RANGES
        return reason, rows, left


@dataclass(frozen=True, eq=False)
class _Task:
    """Pairs to look at again through a candidate, as a repair looked at them."""

    candidate: StereoRig
    pairs: tuple[Pair, ...]
    repair: Solution
    ranges: tuple[Range, ...] = ()

    def data(self, rig: StereoRig, scale: float) -> ScoringData:
        """The pairs with the cameras of a rig."""
        return pyramid(rig, self.pairs, self.repair.view).at(scale)


def _matched(task: _Task) -> Correspondences:
    """The correspondences under the candidate."""
    data = task.data(task.candidate, task.repair.stages[-1].scale)
    return host.correspondences(data, with_unit_baseline(task.candidate.extrinsics), task.repair.matcher)


def _beams(task: _Task) -> Beams:
    """The ranges, matched under the candidate."""
    data = task.data(task.candidate, task.repair.stages[-1].scale)
    return beams(data, task.candidate, task.repair.matcher, task.pairs, task.ranges)


def _fits_ranges_better(member: Member) -> bool:
    """Whether most ranges agree with the solution, and much better than with the initial calibration."""
    if not len(member.beams.metres):
        return False
    before, after = (member.beams.residuals(member.chart.rig_at(z)) for z in (np.zeros_like(member.z), member.z))
    bounded = [float(np.minimum(r**2, _CONTRADICTS**2).sum()) for r in (before, after)]
    return bounded[0] - bounded[1] > _CONTRADICTS**2 and float(np.mean(np.abs(after) < _CONTRADICTS)) > 0.5


def _counted(task: _Task) -> Int[np.ndarray, "2 k tiles"]:
    """Counts of the tiles of all frames at full scale, under the initial calibration and the candidate."""
    return np.stack(
        [
            host.counts_by_tile(task.data(rig, 1.0), with_unit_baseline(rig.extrinsics)[None], task.repair.matcher)[0]
            for rig in (task.repair.initial, task.candidate)
        ]
    )


def _merged(members: Sequence[Member]) -> tuple[Member]:
    """The members as one, with the correspondences of all, from the middle of their solutions."""
    found = [member.found for member in members]
    first = np.cumsum([0, *(len(one.weight) for one in found)])

    def all_of(name: str) -> Float[np.ndarray, "..."]:
        return np.concatenate([np.asarray(getattr(one, name)) for one in found])

    tiles = [np.asarray(one.tile) + before * TILES_OF_A_FRAME for one, before in zip(found, first, strict=False)]
    rays = {name: all_of(name) for name in ("left", "right", "weight")}
    middle = np.median([member.z for member in members], axis=0)
    seen = [member.beams for member in members]
    names = ("left", "right", "metres", "sigma", "matching")
    every = Beams(*(np.concatenate([getattr(one, name) for one in seen]) for name in names))
    return (Member(members[0].chart, replace(found[0], **rays, tile=np.concatenate(tiles)), middle, every),)


def _alike(facts: Sequence[Evidence]) -> float:
    """The misfit that neighbouring regions share, root mean square over all members."""
    return float(np.sqrt(np.mean([misfit(one).alike ** 2 for one in facts])))


def _not_solved(repair: Solution, free: Parameters) -> Intrinsics:
    parameters = [one for one in free.of(repair.initial, repair.reach) if one.name in free.shared]
    missing = np.full(len(parameters), np.nan)
    names, units = tuple(one.name for one in parameters), tuple(one.unit for one in parameters)
    nan = float("nan")
    return Intrinsics(IntrinsicsOutcome.NOT_SOLVED, names, units, missing, missing, names, nan, nan, nan, nan, 0.0, nan)
