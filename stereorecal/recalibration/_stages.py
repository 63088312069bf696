"""Running one stage of a schedule."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig, View
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Chart, Reach, chart_around, epipolar_objective, objective
from stereorecal.recalibration._schedule import ScoreKind, Stage
from stereorecal.recordings import Pair
from stereorecal.scoring import (
    Correspondences,
    Loss,
    correspondences,
    normalised,
    precisions,
    prepare,
    row_differences,
)
from stereorecal.strategies import Budget, Objective, Run, Status, run_strategy

WIDER = 2.0  # the box of the epipolar stages, in reaches
PRIOR = 1.0 / 3.0  # standard deviation of the drift, in reaches: the default reach of 3° and 3 % means 1° and 1 %
FEWEST = 60  # correspondences; five parameters from fewer would be guessing
_FIRST = (Loss.SOFT_L1, Loss.WELSCH, Loss.WELSCH)
_AGAIN = (Loss.WELSCH, Loss.WELSCH)
_FAR = 0.05  # pixels, median change of the row differences by a round: one that moves more still approaches
_SETTLED = 0.015  # pixels, the same by what the mean of the others moves: they scatter by about so much


@dataclass(frozen=True, eq=False)
class Case:
    """What is repaired, and with what.

    Attributes:
        rig: the calibration that the user gave; the centre of the chart and of the prior.
        matcher: with its disparity range at full size.
    """

    rig: StereoRig
    pairs: Sequence[Pair]
    matcher: AbstractMatcher
    view: View
    reach: Reach

    @property
    def chart(self) -> Chart:
        """Unit box to extrinsics, to twice the reach: the count must be fenced in, but the epipolar residuals know a
        prior, and a drift a little beyond the reach is better found than cut off."""
        within = chart_around(self.rig, self.reach)
        return replace(within, half_width=WIDER * within.half_width)

    def rig_at(self, z: Float[np.ndarray, "n"]) -> StereoRig:
        """The rig at a point of the chart's box."""
        return self.rig.with_extrinsics(self.chart.extrinsics(z))

    def with_matcher(self, matcher: AbstractMatcher) -> "Case":
        """The same case with another matcher."""
        return replace(self, matcher=matcher)


@dataclass(frozen=True, eq=False)
class StageRun:
    """What a stage did.

    Attributes:
        stage: as asked for.
        scale: at which it worked.
        start, best: (n,) where it began and ended, in the unit box: the best of its run on the count, the mean of the
            last rounds on the rows.
        runs: of the strategy; several in an epipolar stage, where each round weighs the correspondences anew.
        matching_cost: units that went into finding correspondences.
        found: the last correspondences; None in a stage on the count, and where the budget allowed none.
        cut: the budget ended an epipolar stage before a round was solved.
    """

    stage: Stage
    scale: float
    start: Float[np.ndarray, "n"]
    best: Float[np.ndarray, "n"]
    runs: tuple[Run, ...]
    matching_cost: float = 0.0
    found: Correspondences | None = None
    cut: bool = False

    @property
    def cost(self) -> float:
        """Units spent."""
        return self.matching_cost + sum(run.trace.total_cost for run in self.runs)

    @property
    def evaluations(self) -> int:
        """How often the stage's score was asked."""
        return sum(len(run.trace.values) for run in self.runs)


def run_stage(case: Case, stage: Stage, start: Float[np.ndarray, "n"], budget: Budget, seed: int) -> StageRun:
    """Run a stage from `start`, a point of the unit box.

    Raises:
        NeedNotMet: if the strategy needs what the stage's score does not offer.
        StrategyError: if the strategy crashes.
    """
    return (_count_stage if stage.score is ScoreKind.COUNT else _epipolar_stage)(case, stage, start, budget, seed)


def better_start(case: Case, stage: Stage, other: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """The centre of the box, or `other` where the count at the scale of `stage` is higher."""
    centre = np.zeros_like(other)
    if not other.any():
        return centre
    asked = _count_objective(case, stage.scale_for(case.rig.left.size))
    here, there = asked.problem.values(np.clip(WIDER * np.stack([centre, other]), -1.0, 1.0))
    return other if there > here else centre


def _count_objective(case: Case, scale: float) -> Objective:
    return objective(case.rig, case.pairs, matcher=case.matcher, reach=case.reach, view=case.view, scale=scale)


def _count_stage(case: Case, stage: Stage, start: np.ndarray, budget: Budget, seed: int) -> StageRun:
    scale = stage.scale_for(case.rig.left.size)
    run = run_strategy(stage.strategy, _count_objective(case, scale), np.clip(WIDER * start, -1.0, 1.0), budget, seed)
    return StageRun(stage, scale, start, run.best / WIDER, (run,))


def _epipolar_stage(case: Case, stage: Stage, start: np.ndarray, budget: Budget, seed: int) -> StageRun:
    """Match, weigh, solve; the weights follow the solution a few times, then the images are matched again.

    Matched anew, a window meets other pixels, so each round ends about a hundredth of a pixel elsewhere. Once rounds no
    longer approach, the mean of their ends counts, and the next begins there (Robbins & Monro 1951, gains of 1 / n).
    """
    scale = stage.scale_for(case.rig.left.size)
    data, matcher, chart = prepare(case.rig, case.pairs, case.view, scale), case.matcher.scaled(scale), case.chart
    matching = len(case.pairs) * scale**2
    began, found, cut = time.perf_counter(), None, False
    best, runs, rounds, near = start, [], 0, 0

    def left() -> Budget | None:
        return remaining(budget, rounds * matching + sum(run.trace.total_cost for run in runs), began)

    for losses in (_FIRST, *[_AGAIN] * (stage.rounds - 1)):
        allowed = left()
        if allowed is None or (allowed.evaluations is not None and allowed.evaluations < matching):
            cut = found is None
            break
        found = correspondences(data, normalised(chart.extrinsics(best)), matcher, scale)
        rounds += 1
        if found.found < FEWEST:
            break
        before = differences = differences_at(found, chart, best)
        end = best
        for loss in losses:
            allowed = left()
            if allowed is None:
                break
            asked = epipolar_objective(found, precisions(found, differences, loss), chart, PRIOR / WIDER)
            runs.append(run_strategy(stage.strategy, asked, end, allowed, seed))
            end = runs[-1].best
            differences = differences_at(found, chart, end)
        moved = float(np.median(np.abs(differences - before)[np.asarray(found.weight) > 0]))
        near = near + 1 if moved < _FAR else 0
        best = best + (end - best) / max(near, 1)
        cut = allowed is None or runs[-1].status is Status.BUDGET
        if cut or (near and moved / near < _SETTLED):
            break
    return StageRun(stage, scale, start, best, tuple(runs), rounds * matching, found, cut)


def differences_at(found: Correspondences, chart: Chart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "k m"]:
    """The row differences at a point of the unit box, in pixels of the scale of `found`."""
    return np.asarray(row_differences(found, normalised(chart.extrinsics(z))))


def remaining(budget: Budget, cost: float, began: float) -> Budget | None:
    """What may still be spent; None if that is nothing."""
    units = None if budget.evaluations is None else budget.evaluations - cost
    seconds = None if budget.seconds is None else budget.seconds - (time.perf_counter() - began)
    if (units is not None and units <= 0) or (seconds is not None and seconds <= 0):
        return None
    return Budget(units, seconds)
