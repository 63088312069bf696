"""The tasks of the experiments, of four kinds; each runs in a worker and returns its row."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal.estimation import EXACT
from stereorecal.geometry import AXES, StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration import Schedule, Solution, recalibrate, recalibrate_sequence
from stereorecal.recordings import Pair, PairSequence, names_of
from stereorecal.reproduction._judge import Judge
from stereorecal.strategies import Budget

Row = dict[str, Any]
"""Plain data: what JSON holds."""


@dataclass(frozen=True, eq=False)
class Shot:
    """One pair of a mission, and the judge that counts it.

    Attributes:
        frame: the pair, alone: there may be more shots than fit into the memory, and so each reads its own.
        starred: whether it shows little to match, such as open sea.
    """

    sequence: str
    frame: PairSequence
    starred: bool
    judge: Judge

    @property
    def pair(self) -> Pair:
        """Read, if it is read when it is asked for."""
        return self.frame[0]

    @property
    def image(self) -> str:
        """Name of the pair."""
        return names_of(self.frame)[0]

    @property
    def key(self) -> str:
        """A name that no other shot of a log has."""
        return f"{self.sequence}/{self.image}"

    @property
    def about(self) -> Row:
        """What every row says of its pair."""
        return {"sequence": self.sequence, "image": self.image, "starred": self.starred}

    def counted(self, *rigs: StereoRig) -> Row:
        """N_i, N_o and N_GT: the counts under the rig before, the rig after, and the manual calibration."""
        extrinsics = [np.asarray(rig.extrinsics) for rig in (*rigs, self.judge.rig)]
        return dict(zip(_WHEN, self.judge.counts(self.pair, extrinsics), strict=True))


@dataclass(frozen=True)
class Method:
    """A way to repair.

    Attributes:
        name: in tables.
        schedule: what is run.
        ranged: whether it takes the judge's disparity range, like the paper's fixed stereo settings, instead of
            measuring its own.
    """

    name: str
    schedule: Schedule
    ranged: bool


@dataclass(frozen=True)
class Search:
    """A method with its limits."""

    method: Method
    reach: Reach
    budget: Budget
    seed: int

    def arguments(self, judge: Judge) -> dict[str, Any]:
        """Those of `recalibrate`; everything is scored in the judge's view."""
        return {
            "matcher": judge.matcher if self.method.ranged else replace(judge.matcher, num_disparities=None),
            "schedule": self.method.schedule,
            "reach": self.reach,
            "budget": self.budget,
            "view": judge.view,
            "seed": self.seed,
        }


@dataclass(frozen=True, eq=False)
class Counting:
    """The counts of one pair under many calibrations.

    Attributes:
        own: name of the calibration that holds for it.
        extrinsics: (6,) each, by the name of the calibration.
    """

    shot: Shot
    own: str
    extrinsics: dict[str, np.ndarray]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return self.shot.key

    def run(self) -> Row:
        """Count."""
        found = self.shot.judge.counts(self.shot.pair, list(self.extrinsics.values()))
        counts = dict(zip(self.extrinsics, found, strict=True))
        return {**self.shot.about, "own": self.own, "counts": counts}


@dataclass(frozen=True, eq=False)
class Sweep:
    """The count of one pair along one axis, through the reference.

    Attributes:
        axis: index of the parameter among pitch, yaw, roll, x, y, z.
        matcher_name: what the matcher is called in rows.
        offsets: degrees, or percent of the baseline.
    """

    shot: Shot
    axis: int
    matcher_name: str
    matcher: AbstractMatcher
    offsets: tuple[float, ...]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.shot.key}/{self._names['axis']}/{self._names['matcher']}"

    @property
    def _names(self) -> dict[str, str]:
        return {"axis": AXES[self.axis], "matcher": self.matcher_name}

    def run(self) -> Row:
        """Count."""
        reference = self.shot.judge.reference
        unit = np.radians(1.0) if self.axis < 3 else 0.01 * float(reference.baseline)
        steps = unit * np.eye(6)[self.axis] * np.array(self.offsets)[:, None]
        judge = self.shot.judge.with_matcher(self.matcher)
        counts = judge.counts(self.shot.pair, list(reference.extrinsics + steps))
        return {**self.shot.about, **self._names, "offsets": list(self.offsets), "counts": counts}


@dataclass(frozen=True, eq=False)
class Repairing:
    """One pair repaired from one start: N_i, N_o, N_GT, and what was reached at which cost.

    Attributes:
        start_name, start: the calibration to begin with.
        others: other pairs of the sequence, counted before and after.
    """

    shot: Shot
    start_name: str
    start: StereoRig
    search: Search
    others: tuple[Shot, ...] = ()

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.shot.key}/{self.start_name}/{self.search.method.name}"

    def run(self) -> Row:
        """Repair and count."""
        shot = self.shot
        solution = recalibrate(self.start, [shot.pair], prior=EXACT, **self.search.arguments(shot.judge))
        return {
            **shot.about,
            "calibration": self.start_name,
            "schedule": self.search.method.name,
            **_found(shot, solution),
            "start_error": _errors(shot.judge, self.start),
            "others": {
                other.image: {"starred": other.starred, **other.counted(self.start, solution.rig)}
                for other in self.others
            },
        }


@dataclass(frozen=True, eq=False)
class InTurn:
    """Pairs of a sequence repaired one after the other, each from the calibration that the one before left.

    Attributes:
        order: what the order of the pairs is called.
        shots: in that order; one that comes twice is looked at twice.
    """

    order: str
    start: StereoRig
    search: Search
    shots: tuple[Shot, ...]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.shots[0].sequence}/{self.order}/{self.search.method.name}"

    def run(self) -> Row:
        """Repair and count."""
        judge, pairs = self.shots[0].judge, [shot.pair for shot in self.shots]
        solutions = recalibrate_sequence(self.start, pairs, **self.search.arguments(judge))
        return {
            "sequence": self.shots[0].sequence,
            "order": self.order,
            "schedule": self.search.method.name,
            "steps": [
                {"image": shot.image, "starred": shot.starred, **_found(shot, solution)}
                for shot, solution in zip(self.shots, solutions, strict=True)
            ],
            **_errors(judge, solutions[-1].rig),
            "seconds": sum(solution.seconds for solution in solutions),
        }


Task = Counting | Sweep | Repairing | InTurn
_WHEN = ("score_initial", "score_final", "score_reference")


def _found(shot: Shot, solution: Solution) -> Row:
    """What a repair made of its pair. The way ends at the rig that is used: that of a rejected repair is its start."""
    path = solution.path if solution.accepted else solution.path[:1]
    return {
        **shot.counted(solution.initial, solution.rig),
        "accepted": solution.accepted,
        "reason": solution.reason.name.lower(),
        "evaluations": solution.evaluations,
        "cost": solution.cost.budgeted + solution.cost.survey,
        "cost_budgeted": solution.cost.budgeted,
        "cost_total": solution.cost.total,
        "seconds": solution.seconds,
        **_errors(shot.judge, solution.rig),
        "extrinsics": {"start": solution.initial.extrinsics, "found": solution.rig.extrinsics},
        "way": shot.judge.way(shot.pair, path),
    }


def _errors(judge: Judge, rig: StereoRig) -> Row:
    rotation, translation = judge.errors(np.asarray(rig.extrinsics))
    return {"rotation_error_deg": rotation, "translation_error_percent": translation}
