"""The tasks of the experiments, of four kinds; each runs in a worker and returns a row of results."""

from dataclasses import dataclass, replace

import numpy as np

from stereorecal.estimation import EXACT
from stereorecal.geometry import AXES, StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration import Schedule, Solution, recalibrate
from stereorecal.strategies import Budget
from stereorecal_paper._logged_pair import LoggedPair, Row
from stereorecal_paper._pixel_counter import PixelCounter


@dataclass(frozen=True)
class Method:
    """A way to repair.

    Attributes:
        name: in tables.
        schedule: what is run.
        ranged: whether it takes the counter's disparity range, like the paper's fixed stereo settings, instead of
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

    def repaired(self, rig: StereoRig, logged_pair: LoggedPair) -> Solution:
        """The repair of a pair from a rig whose intrinsics are exact; everything is scored in the counter's view."""
        counter = logged_pair.counter
        return recalibrate(
            rig,
            [logged_pair.pair],
            matcher=counter.matcher if self.method.ranged else replace(counter.matcher, num_disparities=None),
            schedule=self.method.schedule,
            reach=self.reach,
            budget=self.budget,
            view=counter.view,
            seed=self.seed,
            prior=EXACT,
        )


@dataclass(frozen=True, eq=False)
class PairCounts:
    """The counts of one pair under many calibrations.

    Attributes:
        own: name of the calibration that holds for it.
        extrinsics: (6,) each, by the name of the calibration.
    """

    logged_pair: LoggedPair
    own: str
    extrinsics: dict[str, np.ndarray]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return self.logged_pair.key

    def run(self) -> Row:
        """Count."""
        found = self.logged_pair.counter.counts(self.logged_pair.pair, list(self.extrinsics.values()))
        counts = dict(zip(self.extrinsics, found, strict=True))
        return {**self.logged_pair.about, "own": self.own, "counts": counts}


@dataclass(frozen=True, eq=False)
class AxisSweep:
    """The count of one pair along one axis, through the reference.

    Attributes:
        axis: index of the parameter among pitch, yaw, roll, x, y, z.
        matcher_name: what the matcher is called in rows.
        offsets: degrees, or percent of the baseline.
    """

    logged_pair: LoggedPair
    axis: int
    matcher_name: str
    matcher: AbstractMatcher
    offsets: tuple[float, ...]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.logged_pair.key}/{self._names['axis']}/{self._names['matcher']}"

    @property
    def _names(self) -> dict[str, str]:
        return {"axis": AXES[self.axis], "matcher": self.matcher_name}

    def run(self) -> Row:
        """Count."""
        reference = self.logged_pair.counter.reference
        unit = np.radians(1.0) if self.axis < 3 else 0.01 * float(reference.baseline)
        steps = unit * np.eye(6)[self.axis] * np.array(self.offsets)[:, None]
        counter = self.logged_pair.counter.with_matcher(self.matcher)
        counts = counter.counts(self.logged_pair.pair, list(reference.extrinsics + steps))
        return {**self.logged_pair.about, **self._names, "offsets": list(self.offsets), "counts": counts}


@dataclass(frozen=True, eq=False)
class PairRepair:
    """One pair repaired from one start: N_i, N_o, N_GT, and what was reached at which cost.

    Attributes:
        start_name, start: the calibration to begin with.
        others: other pairs of the sequence, counted before and after.
    """

    logged_pair: LoggedPair
    start_name: str
    start: StereoRig
    search: Search
    others: tuple[LoggedPair, ...] = ()

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.logged_pair.key}/{self.start_name}/{self.search.method.name}"

    def run(self) -> Row:
        """Repair and count."""
        logged_pair = self.logged_pair
        solution = self.search.repaired(self.start, logged_pair)
        return {
            **logged_pair.about,
            "calibration": self.start_name,
            "schedule": self.search.method.name,
            **_found(logged_pair, solution),
            "start_error": _errors(logged_pair.counter, self.start),
            "others": {
                other.image: {"starred": other.starred, **other.counted(self.start, solution.rig)}
                for other in self.others
            },
        }


@dataclass(frozen=True, eq=False)
class SequentialRepairs:
    """Pairs of a sequence repaired one after the other, each from the calibration that the one before left.

    Attributes:
        order: what the order of the pairs is called.
        logged_pairs: in that order; one that comes twice is repaired twice.
    """

    order: str
    start: StereoRig
    search: Search
    logged_pairs: tuple[LoggedPair, ...]

    @property
    def key(self) -> str:
        """A name that no other task of an experiment has."""
        return f"{self.logged_pairs[0].sequence}/{self.order}/{self.search.method.name}"

    def run(self) -> Row:
        """Repair and count."""
        counter = self.logged_pairs[0].counter
        solutions, rig = [], self.start
        for logged_pair in self.logged_pairs:
            solutions.append(self.search.repaired(rig, logged_pair))
            rig = solutions[-1].rig
        return {
            "sequence": self.logged_pairs[0].sequence,
            "order": self.order,
            "schedule": self.search.method.name,
            "steps": [
                {"image": logged_pair.image, "starred": logged_pair.starred, **_found(logged_pair, solution)}
                for logged_pair, solution in zip(self.logged_pairs, solutions, strict=True)
            ],
            **_errors(counter, solutions[-1].rig),
            "seconds": sum(solution.seconds for solution in solutions),
        }


Task = PairCounts | AxisSweep | PairRepair | SequentialRepairs


def _found(logged_pair: LoggedPair, solution: Solution) -> Row:
    """The results of a repair. The path ends at the rig that is used: the initial one if the candidate was rejected."""
    path = solution.path if solution.accepted else solution.path[:1]
    return {
        **logged_pair.counted(solution.initial, solution.rig),
        "accepted": solution.accepted,
        "reason": solution.reason.name.lower(),
        "evaluations": solution.evaluations,
        "cost": solution.cost.budgeted + solution.cost.survey,
        "cost_budgeted": solution.cost.budgeted,
        "cost_total": solution.cost.total,
        "seconds": solution.seconds,
        **_errors(logged_pair.counter, solution.rig),
        "extrinsics": {"start": solution.initial.extrinsics, "found": solution.rig.extrinsics},
        "way": logged_pair.counter.way(logged_pair.pair, path),
    }


def _errors(counter: PixelCounter, rig: StereoRig) -> Row:
    rotation, translation = counter.errors(np.asarray(rig.extrinsics))
    return {"rotation_error_deg": rotation, "translation_error_percent": translation}
