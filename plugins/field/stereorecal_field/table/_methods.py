"""Methods: what each makes of a case. All get the same images, the same start, and are told the same."""

import abc
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stereorecal import InputError, StrategyError
from stereorecal.cli import checked_choice, versions
from stereorecal.comparison import load_strategies
from stereorecal.estimation import is_exact
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach, StereoImages, count_chart
from stereorecal.recalibration import Schedule, Solution, recalibrate
from stereorecal.strategies import (
    AbstractStrategy,
    BudgetExhausted,
    Need,
    NeedNotMet,
    Objective,
    Problem,
    Status,
    origin_of,
    strategies,
)
from stereorecal_field.judges import Case

ACCEPTED, GOOD, REFUSED = "accepted", "good", "refused"
_FAR = 30  # baselines, at which intervals are compared
_EXTRINSICS = "pitch, yaw, roll, y, z"
METHODS = ("count", "rows", "motion")  # of the library; all others are strategies


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method says.

    Attributes:
        rig: the calibration to use: the start, unless the method would replace it.
        status: ACCEPTED (the rig is another one), GOOD (the method says that nothing is wrong) or REFUSED.
        message: in its own words.
        stated: 95 % interval of the error of depth at 30 baselines [%] of that rig; None if it states none.
    """

    rig: StereoRig
    status: str
    message: str
    stated: tuple[float, float] | None = None


@dataclass(frozen=True)
class AbstractMethod(abc.ABC):
    """A method by name.

    Class attributes:
        changes: what it may change in a calibration.
    """

    changes: ClassVar[str] = _EXTRINSICS

    name: str

    @property
    @abc.abstractmethod
    def origin(self) -> str:
        """Where it comes from, and its version."""

    @abc.abstractmethod
    def solve(self, case: Case, matcher: AbstractMatcher, reach: Reach, seed: int) -> Answer:
        """Its answer.

        Raises:
            NeedNotMet: if the case does not offer what it needs.
        """


@dataclass(frozen=True)
class Library(AbstractMethod):
    """`sr.recalibrate`, in one of three ways: by the count alone (as the paper), by rows, by rows and the rig's own
    motion."""

    changes: ClassVar[str] = f"{_EXTRINSICS}; all where frames of four places prove it"

    @property
    def origin(self) -> str:
        return f"stereorecal {versions()['stereorecal']}"

    def solve(self, case: Case, matcher: AbstractMatcher, reach: Reach, seed: int) -> Answer:
        how = {"matcher": matcher, "reach": reach, "seed": seed, "prior": case.prior}
        if self.name == "count":
            return _answer(recalibrate(case.start, case.pairs, schedule="count", motion=False, **how))
        if self.name == "motion":
            _check_motion(case)
        return _answer(recalibrate(case.start, case.pairs, motion=None if self.name == "motion" else False, **how))


@dataclass(frozen=True)
class Strategy(AbstractMethod):
    """A strategy of the registry. One that works from the images answers for itself: what it converged to is used, and
    what it stalled at is not. Any other searches the count, which judges it."""

    strategy: AbstractStrategy

    @property
    def origin(self) -> str:
        return origin_of(self.strategy)

    def solve(self, case: Case, matcher: AbstractMatcher, reach: Reach, seed: int) -> Answer:
        if self.strategy.needs is not Need.IMAGES:
            schedule = Schedule.count(self.strategy)
            how = {"matcher": matcher, "reach": reach, "seed": seed, "prior": case.prior, "motion": False}
            return _answer(recalibrate(case.start, case.pairs, schedule=schedule, **how))
        chart = count_chart(case.start, reach)
        images = StereoImages(case.start, case.pairs, chart)
        try:
            outcome = self.strategy.run(
                Objective(Problem(chart.dim, _no_score, images=images)), np.zeros(chart.dim), seed
            )
        except BudgetExhausted:
            return Answer(case.start, REFUSED, Status.BUDGET.value)
        point = np.asarray(outcome.best, float)
        if point.shape != (chart.dim,) or not (np.abs(point) <= 1.0 + 1e-9).all():
            raise StrategyError(f"strategy {self.name} ({self.origin}) nominated no point of the unit box.")
        message = outcome.message or outcome.status.value
        if outcome.status is not Status.CONVERGED:
            return Answer(case.start, REFUSED, message)
        return Answer(case.start.with_extrinsics(np.asarray(chart.extrinsics(point))), ACCEPTED, message)


def methods_of(names: Sequence[str] | None) -> tuple[AbstractMethod, ...]:
    """The methods of these names: the library's, and strategies; by default all of the library and all installed
    strategies that work from the images.

    Raises:
        InputError: if a name is unknown, or given twice.
    """
    installed = strategies()
    if names is None:
        return (
            *map(Library, METHODS),
            *(made for made in map(_strategy, installed) if made.strategy.needs is Need.IMAGES),
        )
    if len(set(names)) < len(names):
        raise InputError("a method is named twice; name each once.")
    for name in names:
        checked_choice(name, [*METHODS, *installed], "method")
    return tuple(Library(name) if name in METHODS else _strategy(name) for name in names)


def _strategy(name: str) -> Strategy:
    return Strategy(name, load_strategies([name])[name])


def _answer(solution: Solution) -> Answer:
    stated = None
    if solution.expected is not None:
        interval = solution.expected.depth_percent[_FAR]
        stated = float(interval.low), float(interval.high)
    status = ACCEPTED if solution.accepted else GOOD if solution.reason.healthy else REFUSED
    return Answer(solution.rig, status, solution.reason.name.lower(), stated)


def _check_motion(case: Case) -> None:
    if is_exact(case.prior):
        raise NeedNotMet("the method motion estimates depth, which exact intrinsics leave known; leave it out.")
    if sum(pair.time is not None for pair in case.pairs) < 2:
        raise NeedNotMet("method motion needs two pairs or more that know their times.")


def _no_score(points: np.ndarray) -> np.ndarray:
    raise StrategyError("a strategy that works from the images asked for a score, which the field does not give.")
