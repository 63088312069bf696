"""What the experiments ask of a worker: four kinds of task, each with the row that answers it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal.comparison.paper._judge import Judge
from stereorecal.geometry import AXES, Pair, StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration import Schedule, Solution, recalibrate, recalibrate_sequence
from stereorecal.strategies import Budget, Reach

Row = dict[str, Any]
"""Plain data: what JSON holds."""


@dataclass(frozen=True, eq=False)
class Counting:
    """The counts of one pair under many calibrations.

    Attributes:
        sequence, image, starred: which pair.
        own: name of the calibration that holds for it.
        extrinsics: (6,) each, by the name of the calibration.
    """

    sequence: str
    image: str
    starred: bool
    own: str
    extrinsics: dict[str, np.ndarray]
    pair: Pair
    judge: Judge

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.sequence}/{self.image}"

    def run(self) -> Row:
        """Count."""
        found = self.judge.counts(self.pair, list(self.extrinsics.values()))
        counts = dict(zip(self.extrinsics, found, strict=True))
        return {**_about(self), "own": self.own, "counts": counts}


@dataclass(frozen=True, eq=False)
class Sweep:
    """The count of one pair along one axis, through the reference.

    Attributes:
        axis: index of the parameter among pitch, yaw, roll, x, y, z.
        offsets: degrees, or percent of the baseline.
    """

    sequence: str
    image: str
    starred: bool
    axis: int
    matcher: AbstractMatcher
    offsets: tuple[float, ...]
    pair: Pair
    judge: Judge

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.sequence}/{self.image}/{self._names['axis']}/{self._names['matcher']}"

    @property
    def _names(self) -> dict[str, str]:
        return {
            "axis": AXES[self.axis],
            "matcher": type(self.matcher).__name__.lower(),
        }

    def run(self) -> Row:
        """Count."""
        reference = self.judge.reference
        unit = np.radians(1.0) if self.axis < 3 else 0.01 * float(reference.baseline)
        steps = unit * np.eye(6)[self.axis] * np.array(self.offsets)[:, None]
        counts = self.judge.with_matcher(self.matcher).counts(self.pair, list(reference.extrinsics + steps))
        return {**_about(self), **self._names, "offsets": list(self.offsets), "counts": counts}


@dataclass(frozen=True, eq=False)
class Repairing:
    """One pair repaired from one start; N_i, N_o, N_GT and the way there.

    Attributes:
        start_name, start: the calibration to begin with.
        method, schedule: how to repair.
        ranged: whether the repair is given the disparity range of the judge, as the paper's fixed stereo settings are,
            or measures its own.
        others: more pairs of the sequence, counted before and after.
        others_starred: names of those of which little is to be expected.
    """

    sequence: str
    image: str
    starred: bool
    start_name: str
    start: StereoRig
    method: str
    schedule: Schedule
    ranged: bool
    reach: Reach
    budget: Budget
    seed: int
    pair: Pair
    judge: Judge
    others: tuple[Pair, ...] = ()
    others_starred: frozenset[str] = frozenset()

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.sequence}/{self.image}/{self.start_name}/{self.method}"

    def run(self) -> Row:
        """Repair and count."""
        solution = recalibrate(
            self.start,
            [self.pair],
            matcher=self.judge.matcher if self.ranged else None,
            schedule=self.schedule,
            reach=self.reach,
            budget=self.budget,
            view=self.judge.view,
            seed=self.seed,
        )
        three = [np.asarray(rig.extrinsics) for rig in (self.start, solution.rig, self.judge.rig)]
        others = {
            pair.name: {
                "starred": pair.name in self.others_starred,
                **dict(zip(_WHEN, self.judge.counts(pair, three), strict=True)),
            }
            for pair in self.others
        }
        return {
            **_about(self),
            "calibration": self.start_name,
            "schedule": self.method,
            **dict(zip(_WHEN, self.judge.counts(self.pair, three), strict=True)),
            **_verdict(solution),
            **_errors(self.judge, solution.rig),
            "start_error": _errors(self.judge, self.start),
            "extrinsics": {"start": self.start.extrinsics, "found": solution.rig.extrinsics},
            "way": _way(self.judge, self.pair, solution),
            "others": others,
        }


@dataclass(frozen=True, eq=False)
class Sailing:
    """Pairs repaired one after the other, each from where the one before ended.

    Attributes:
        order: what the order of the pairs is called.
        pairs: in that order; one that comes twice is looked at twice.
        starred: names of those of which little is to be expected.
    """

    sequence: str
    order: str
    start: StereoRig
    method: str
    schedule: Schedule
    ranged: bool
    reach: Reach
    budget: Budget
    seed: int
    pairs: tuple[Pair, ...]
    starred: frozenset[str]
    judge: Judge

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.sequence}/{self.order}/{self.method}"

    def run(self) -> Row:
        """Repair and count."""
        solutions = recalibrate_sequence(
            self.start,
            self.pairs,
            matcher=self.judge.matcher if self.ranged else None,
            schedule=self.schedule,
            reach=self.reach,
            budget=self.budget,
            view=self.judge.view,
            seed=self.seed,
        )
        return {
            "sequence": self.sequence,
            "order": self.order,
            "schedule": self.method,
            "steps": [self._step(pair, found) for pair, found in zip(self.pairs, solutions, strict=True)],
            **_errors(self.judge, solutions[-1].rig),
            "seconds": sum(found.seconds for found in solutions),
        }

    def _step(self, pair: Pair, solution: Solution) -> Row:
        before, after, reference = self.judge.counts(
            pair, [np.asarray(rig.extrinsics) for rig in (solution.initial, solution.rig, self.judge.rig)]
        )
        return {
            "image": pair.name,
            "starred": pair.name in self.starred,
            **dict(zip(_WHEN, (before, after, reference), strict=True)),
            **_verdict(solution),
            **_errors(self.judge, solution.rig),
            "extrinsics": {"start": solution.initial.extrinsics, "found": solution.rig.extrinsics},
            "way": _way(self.judge, pair, solution),
        }


Task = Counting | Sweep | Repairing | Sailing
_WHEN = ("score_initial", "score_final", "score_reference")


def _about(task: Counting | Sweep | Repairing) -> Row:
    return {"sequence": task.sequence, "image": task.image, "starred": task.starred}


def _way(judge: Judge, pair: Pair, solution: Solution) -> list[dict[str, float]]:
    """The way to the rig that is used: a refused repair has gone nowhere."""
    return judge.way(pair, solution.path if solution.accepted else solution.path[:1])


def _verdict(solution: Solution) -> Row:
    return {
        "accepted": solution.accepted,
        "reason": solution.reason.name.lower(),
        "evaluations": solution.evaluations,
        "cost": solution.cost + solution.survey_cost,
        "seconds": solution.seconds,
    }


def _errors(judge: Judge, rig: StereoRig) -> Row:
    rotation, translation = judge.errors(np.asarray(rig.extrinsics))
    return {"rotation_error_deg": rotation, "translation_error_percent": translation}
