"""The common solution of recordings of one rig, and what is to be said of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, SIDES, Parameter, Parameters, read_by, row_chart
from stereorecal.recalibration import _unseen
from stereorecal.recalibration._acceptance import WORSE, Reason, RowErrors, Verdict, compared
from stereorecal.recalibration._agreement import MOST_APART, disagreeing
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, mean_by
from stereorecal.recalibration._expected import expected
from stereorecal.recalibration._intrinsics import Gain, Intrinsics, outcome
from stereorecal.recalibration._joint import Joint, Member, joint, solved_together
from stereorecal.recalibration._judging import judged
from stereorecal.recalibration._misfit import EFFECT, Misfit, misfit
from stereorecal.recalibration._ranges import NONE, Beams
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import FEWEST
from stereorecal.recalibration._tasks import Each, Task, beams_of, matched
from stereorecal.recalibration._uncertainty import NORMAL_95, OBSERVED, Uncertainty, uncertainty
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import Correspondences

_MATCHED_AGAIN = 1  # times, under the rig found so far: far from it, windows at the edges of the view meet other things
_FOLDS_OF_FRAMES = 4  # of one recording, for cross-validation
_UNUSABLE = (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES)


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

    def task(self, *rigs: StereoRig) -> Task:
        """To look at the kept pairs through rigs, as the repair looked at them."""
        repair = self.repair
        return Task(rigs, self.kept, repair.view, repair.matcher, repair.stages[-1].scale, self.ranges)


@dataclass(frozen=True, eq=False)
class Solved:
    """The common solution.

    Attributes:
        recordings: those that take part.
        members: one for each, or one for all.
        free: own and shared parameters.
        beams: the ranges of each recording that had a sure match; members do without those that contradict it.
    """

    recordings: Sequence[Recording]
    members: tuple[Member, ...]
    free: Parameters
    beams: tuple[Beams, ...] = field(repr=False)

    @staticmethod
    def of(recordings: Sequence[Recording], free: Parameters, *, one: bool, each: Each) -> "Solved":
        """Solved, matched again, solved again.

        Args:
            one: all recordings have the same extrinsics.
            each: runs a task for each recording.
        """
        if any(r.ranges for r in recordings):
            beams = tuple(each(beams_of, [r.task(r.repair.candidate) for r in recordings]))
        else:
            beams = (NONE,) * len(recordings)
        members = tuple(r.member(free, some) for r, some in zip(recordings, beams, strict=True))
        solved = Solved(recordings, _merged(members) if one else members, free, beams)._solved_again()
        for _ in range(_MATCHED_AGAIN):
            solved = solved._matched_again(one=one, each=each)
        return solved._without_contradictions()

    def _matched_again(self, *, one: bool, each: Each) -> "Solved":
        rigs = self.rigs
        again = each(matched, [replace(r.task(rig), ranges=()) for rig, r in zip(rigs, self.recordings, strict=True)])
        members = []
        for index, (found, rig, r) in enumerate(zip(again, rigs, self.recordings, strict=True)):
            here = self.member(index)
            # One member for all has no correspondences of this recording alone; the repair has.
            before = r.found if one else here.found
            assert before is not None
            read = read_by(found, taken=rig, rig=r.repair.initial) if found.found >= FEWEST else before
            members.append(replace(here, found=read, beams=self.beams[index]))
        return replace(self, members=_merged(members) if one else tuple(members))._solved_again()

    def _without_contradictions(self) -> "Solved":
        """Where most ranges of a member contradict the solution, they are of other things or in other units: it is
        solved again without them."""
        members = tuple(m if not m.beams or m.beams.agree(m.chart.rig_at(m.z)) else _unranged(m) for m in self.members)
        if all(new is old for new, old in zip(members, self.members, strict=True)):
            return self
        return replace(self, members=members)._solved_again()

    def _solved_again(self) -> "Solved":
        return replace(self, members=solved_together(self.members, self.own))

    @property
    def own(self) -> int:
        """How many parameters each member has for itself."""
        return len(self.free.axes)

    @property
    def one(self) -> bool:
        """Whether there is one member for several recordings."""
        return len(self.members) < len(self.recordings)

    @property
    def lenses(self) -> bool:
        """Whether intrinsics are free."""
        return bool(self.free.lenses)

    @property
    def rigs(self) -> list[StereoRig]:
        """Of each recording."""
        of_recordings = [self.member(index) for index in range(len(self.recordings))]
        return [member.chart.rig_at(member.z) for member in of_recordings]

    def member(self, index: int) -> Member:
        """Of a recording."""
        return self.members[0 if len(self.members) == 1 else index]

    @cached_property
    def problem(self) -> Joint:
        """At the solution."""
        return joint(self.members, self.own)

    @cached_property
    def by_chance(self) -> Float[np.ndarray, "N N"]:
        """The covariance of all parameters, without the misfit."""
        return self.problem.covariance()

    @cached_property
    def by_misfit(self) -> Float[np.ndarray, "N N"]:
        """What the misfit adds to it."""
        alike = [misfit(member.facts()).alike for member in self.members]
        return self.problem.by_misfit(float(np.sqrt(np.mean(np.square(alike)))))

    @cached_property
    def unseen(self) -> tuple[Float[np.ndarray, "t"], ...]:
        """Row errors of each member's tiles, by solutions that have not seen their place."""
        return _unseen.by_place(self.members, self.own)

    @cached_property
    def fixed(self) -> tuple[Member, ...]:
        """The same correspondences and ranges with the intrinsics as they were."""
        return self._with_lenses_given(())

    @cached_property
    def fixed_unseen(self) -> tuple[Float[np.ndarray, "t"], ...]:
        """As `unseen`, with the intrinsics as they were."""
        return _unseen.by_place(self.fixed, self.own)

    def uncertainty(self, index: int) -> Uncertainty:
        """Of a recording's parameters."""
        where = self.problem.where(0 if len(self.members) == 1 else index)
        here = np.ix_(where, where)
        return uncertainty(self.by_chance[here], self.by_misfit[here], self.member(index).chart)

    @property
    def settled(self) -> tuple[str, ...]:
        """The length of the baseline, where ranges determine it: its prior does not tell then how long it may be."""
        if BASELINE not in self.free.names or not any(member.beams for member in self.members):
            return ()
        at = self.problem.where(0)[self.free.names.index(BASELINE)]
        return (BASELINE,) if np.sqrt(self.by_chance[at, at]) < OBSERVED * self.members[0].chart.prior else ()

    def judged(self) -> Intrinsics:
        """The shared parameters, and whether they are taken."""
        member, problem = self.members[0], self.problem
        chart, shared = member.chart, slice(problem.size - member.chart.dim + self.own, None)
        before, after = self.fixed_unseen, self.unseen
        places = np.concatenate([np.unique(tile % TILES_OF_A_FRAME) for tile in self._tiles])
        here, there = self._elsewhere(self.fixed), self._elsewhere(self.members)
        covariance = self.by_chance + self.by_misfit
        expects = float(np.min([self._expected_rows(index, covariance) for index in range(len(self.members))]))
        scale = self.scale
        shown = len(np.unique(places)) / TILES_OF_A_FRAME
        deviations = np.sqrt(np.diag(covariance)[shared])
        units = chart.units[self.own :]
        lens = np.array([name not in self.settled for name in chart.names[self.own :]])
        fixed_px, freed_px = (float(np.mean(np.concatenate(rows))) for rows in (before, after))
        pooled = float(np.mean(scale * np.concatenate([a - b for b, a in zip(before, after, strict=True)]) > WORSE))
        return Intrinsics(
            outcome=outcome(
                Gain(
                    by_place=self.gain(before),
                    elsewhere=scale * (here - there) if self._has_elsewhere else None,
                    over_stretch=self.gain(self.stretched_unseen),
                    worse=max(pooled, *self.worse) if self.one else pooled,
                ),
                shown=shown,
                expected_px=scale * expects,
                z=member.z[self.own :][lens],
                prior=chart.prior,
            ),
            names=chart.names[self.own :],
            units=tuple(parameter.unit for parameter in chart.parameters[self.own :]),
            change=member.z[self.own :] * units,
            interval=NORMAL_95 * deviations * units,
            undetermined=tuple(
                name for name, d in zip(chart.names[self.own :], deviations, strict=True) if d > OBSERVED * chart.prior
            ),
            fixed_px=fixed_px,
            freed_px=freed_px,
            fixed_elsewhere_px=here,
            freed_elsewhere_px=there,
            shown=shown,
            expected_px=expects,
        )

    def _expected_rows(self, index: int, covariance: Float[np.ndarray, "N N"]) -> float:
        """To be expected over the view of a member, if all parameters have this covariance."""
        member, where = self.members[index], self.problem.where(index)
        rig, view = member.chart.rig_at(member.z), self.recordings[index].repair.view
        return expected(rig, member.chart, member.z, covariance[np.ix_(where, where)], view).rows_px

    def gain(self, before: Sequence[Float[np.ndarray, "t"]]) -> Float[np.ndarray, "p"]:
        """Against other row errors of the same tiles, at each place of the view; pixels of the images in which rows
        were measured."""
        places = [tile % TILES_OF_A_FRAME for tile in self._tiles]
        gains = [mean_by(p, b - a) for p, b, a in zip(places, before, self.unseen, strict=True)]
        return self.scale * mean_by(np.concatenate([np.unique(p) for p in places]), np.concatenate(gains))

    @cached_property
    def worse(self) -> tuple[float, ...]:
        """Of each recording, the share of its regions that lie farther apart than with the intrinsics as they were."""
        found = []
        for index in range(len(self.recordings)):
            at = 0 if len(self.members) == 1 else index
            here = self._tiles_of(index)
            found.append(float(np.mean(self.scale * (self.unseen[at] - self.fixed_unseen[at])[here] > WORSE)))
        return tuple(found)

    def verdict(self, index: int, tiles: Int[np.ndarray, "2 k tiles"]) -> tuple[Verdict, RowErrors, Misfit]:
        """On a recording, or on all where they are one member, whose tiles have these counts before and after."""
        member, at = self.member(index), 0 if len(self.members) == 1 else index
        facts = member.facts()
        rows = compared(facts, facts.medians(facts.start_residual), self.unseen[at])
        said, left = judged(facts, self.free.names, self.own, tiles, rows, member.found.covered, settled=self.settled)
        own = facts.only(slice(self.own))
        if len(disagreeing(own)[0]) > MOST_APART * own.frames:
            said = Verdict(Reason.FRAMES_DISAGREE)
        return said, rows, left

    def _with_lenses_given(self, beside: Sequence[Parameter]) -> tuple[Member, ...]:
        """The same problem with the intrinsics as they were, and other parameters that all share."""
        members = []
        for recording, member in zip(self.recordings, self.members, strict=False):
            rest = tuple(one for one in member.chart.parameters if "." not in one.name)
            chart = replace(member.chart, parameters=(*rest, *beside))
            start = chart.coordinates(np.asarray(recording.repair.candidate.extrinsics))
            members.append(replace(member, chart=chart, z=start))
        return solved_together(members, self.own)

    @cached_property
    def stretched_unseen(self) -> tuple[Float[np.ndarray, "t"], ...]:
        """As `unseen`, with the intrinsics as they were, but pixels that may be oblong, in images that were resized out
        of shape: by so much that no prior on lenses can say otherwise."""
        percent = 100.0 * EFFECT / (0.5 * self.members[0].chart.rig.left.size[1])
        here = self.members[0].chart.names
        beside = [Parameter(f"{side}.aspect", "%", percent, 0.01) for side in SIDES if f"{side}.aspect" not in here]
        return _unseen.by_place(self._with_lenses_given(beside), self.own)

    @cached_property
    def _tiles(self) -> list[Int[np.ndarray, "t"]]:
        """Of each member, those that show something."""
        found = [member.found for member in self.members]
        return [np.unique(np.asarray(one.tile)[np.asarray(one.weight) > 0]) for one in found]

    @property
    def scale(self) -> float:
        """Pixels in which rows were measured, per pixel at full size."""
        return float(self.members[0].found.scale)

    def _tiles_of(self, index: int) -> Bool[np.ndarray, "t"]:
        """Which tiles of its member are a recording's."""
        if len(self.members) == len(self.recordings):
            return np.ones(len(self._tiles[index]), bool)
        return self._of_frames()[self._tiles[0] // TILES_OF_A_FRAME] == index

    @property
    def _has_elsewhere(self) -> bool:
        """Whether there is something that can be left out."""
        return len(self.members) > 1 or bool(self._of_frames().max() > 0)

    def _elsewhere(self, members: tuple[Member, ...]) -> float:
        """Row error of what took no part; NaN where everything did."""
        if not self._has_elsewhere:
            return float("nan")
        recording = self._of_frames() if len(members) == 1 else np.arange(0)
        return float(np.mean(np.concatenate(_unseen.by_recording(members, self.own, recording))))

    def _of_frames(self) -> Int[np.ndarray, "f"]:
        """Which recording each frame belongs to, of one member; of one recording, which stretch of it."""
        if len(self.recordings) > 1:
            return np.repeat(np.arange(len(self.recordings)), [len(r.kept) for r in self.recordings])
        frames = len(self.recordings[0].kept)
        return np.arange(frames) * min(_FOLDS_OF_FRAMES, frames) // frames


def _unranged(member: Member) -> Member:
    return replace(member, beams=NONE)


def _merged(members: Sequence[Member]) -> tuple[Member]:
    """The members as one, with the correspondences of all, from the middle of their solutions."""
    found = [member.found for member in members]
    first = np.cumsum([0, *(len(one.weight) for one in found)])

    def all_of(name: str) -> Float[np.ndarray, "..."]:
        return np.concatenate([np.asarray(getattr(one, name)) for one in found])

    tiles = [np.asarray(one.tile) + before * TILES_OF_A_FRAME for one, before in zip(found, first, strict=False)]
    rays = {name: all_of(name) for name in ("left", "right", "weight")}
    middle = np.median([member.z for member in members], axis=0)
    every = Beams.of_all([member.beams for member in members])
    return (Member(members[0].chart, replace(found[0], **rays, tile=np.concatenate(tiles)), middle, every),)
