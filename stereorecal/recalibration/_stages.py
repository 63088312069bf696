"""Running one stage of a schedule, the way that stages took, and what they cost.

One unit of cost: one matcher run on one full-size frame (a candidate at scale s over k frames: k s²).
"""

import time
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from stereorecal.decision import ENOUGH
from stereorecal.estimation import FEWEST_GROUPS, grouped, rows_of_groups
from stereorecal.geometry import AXES, StereoRig, same_cameras, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import (
    RigChart,
    count_chart,
    count_objective,
    differences_at,
    epipolar_objective,
    linear_residuals,
)
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._schedule import ScoreKind, Stage, as_strategy
from stereorecal.scoring import Correspondences, ScoringData, host, with_rays_of
from stereorecal.scoring.host import survey
from stereorecal.strategies import Budget, Run, Status, run_strategy

_REWEIGHTED = 3  # times that the rows of one match are fitted: groups that err alone, and outliers, follow the fit
_LOOKED = 3  # times that a look may match at its finest scale until it settles, at least
SETTLED = 0.02  # pixels, mean change of the row differences: rigs as near match the same


@dataclass(frozen=True)
class Cost:
    """Units, by what they were spent on.

    Attributes:
        survey: coarse matches that find a start and the disparity range.
        starts: the look at the images, from the start that the survey found.
        search: what strategies asked; with `correspondences`, what a budget pays for.
        correspondences: matches that found correspondences.
        judging: counts that nominations and the end of the schedule were judged by, and matches at vertical offsets.
    """

    survey: float = 0.0
    starts: float = 0.0
    search: float = 0.0
    correspondences: float = 0.0
    judging: float = 0.0

    def __add__(self, other: "Cost") -> "Cost":
        return Cost(*map(sum, zip(astuple(self), astuple(other), strict=True)))

    @property
    def total(self) -> float:
        """All of it."""
        return sum(astuple(self))

    @property
    def budgeted(self) -> float:
        """What a budget pays for: search and correspondences."""
        return self.search + self.correspondences


@dataclass(frozen=True, eq=False)
class Waypoint:
    """Where a repair stood.

    Attributes:
        cost: units spent by then (one unit: one matcher run on one full-size frame).
        extrinsics: (6,) pitch, yaw, roll [rad], x, y, z [m].
    """

    cost: float
    extrinsics: Float[np.ndarray, "6"]


@dataclass(frozen=True, eq=False)
class StageRun:
    """What a stage did.

    Attributes:
        stage: as asked for.
        scale: at which it worked.
        began, ended: the rigs where it began and ended.
        runs: of the strategy; several in an epipolar stage, where each fit weighs the rows anew.
        path: of a stage on the count: each new best, its cost counted from where the stage began.
        cost: what it took; its survey measured the disparity range anew after it.
        found: the last correspondences, with the rays that the initial calibration's cameras give; None in a stage on
            the count, and where the budget allowed none.
        settled: the last fit of an epipolar stage moved no rows any more, so that it would match the same again.
        cut: the budget ended an epipolar stage before a round was solved.
    """

    stage: Stage
    scale: float
    began: StereoRig
    ended: StereoRig
    runs: tuple[Run, ...]
    path: tuple[Waypoint, ...] = ()
    cost: Cost = Cost()
    found: Correspondences | None = None
    settled: bool = False
    cut: bool = False

    @property
    def matches_enough(self) -> bool:
        """Whether its last correspondences are so many that a rig can be fitted to them."""
        return self.found is not None and self.found.found >= ENOUGH.matches

    @property
    def evaluations(self) -> int:
        """How often the stage's score was asked."""
        return sum(len(run.trace.values) for run in self.runs)


def started(case: Case) -> tuple[Case, StereoRig, Cost]:
    """What comes before the first stage: the case with a disparity range, where the stage begins, and what it took."""
    settings, start, cost = case.settings, case.rig, Cost()
    for stage in settings.schedule.on_rows:
        host.compile_in_background(case.images.at(case.scale_of(stage)))
    if settings.schedule.survey or case.matcher.num_disparities is None:
        radians = float(np.radians(settings.reach.degrees))
        yaw = settings.schedule.survey and "yaw" in case.free.axes
        surveyed = survey(case.images, case.rig.extrinsics, radians, yaw=yaw)
        case, cost = replace(case, matcher=surveyed.with_range(case.matcher, radians)), Cost(survey=surveyed.cost)
        moved = {AXES[axis] for axis in np.flatnonzero(surveyed.offset)}
        if settings.schedule.survey and moved and moved <= set(case.free.axes):  # a part of an offset is no start
            start = case.rig.with_extrinsics(np.asarray(case.rig.extrinsics, float) + surveyed.offset)
    return case, start, cost


def run_look(case: Case, stages: Sequence[Stage], start: StereoRig, cost: Cost) -> tuple[StageRun, Cost]:
    """One look at the images from a start, by the stages on the rows, without strategies: matches, which the extrinsics
    are fitted to until both settle. Matches of rows that are not aligned err together, all frames alike, and the
    estimate would explain it by lenses.

    Args:
        case: with a disparity range.
        stages: from coarse to fine; all frames are looked at, since few may show another rig than the others.
        cost: of what came before; it comes back with that of the look, for which no budget pays, as for all before the
            search.

    Returns:
        The last stage, as if it had begun at the start, and the cost.
    """
    case, runs = replace(case, free=case.free.extrinsics), []
    finest = replace(stages[-1], rounds=max(stages[-1].rounds, _LOOKED))
    coarser = [stage for stage in stages[:-1] if case.scale_of(stage) < case.scale_of(finest)]  # small images have none
    for stage in (*coarser, finest):
        of_all = replace(stage, strategy=None, frames=None)
        runs.append(run_stage(case, of_all, runs[-1].ended if runs else start, Budget(), seed=0))
    last = runs[-1]
    ended = last.ended if last.matches_enough else case.rig  # else nothing speaks for the start either
    look = replace(last, began=start, ended=ended, cost=Cost())
    return look, cost + Cost(starts=sum(run.cost.budgeted for run in runs))


def run_stage(case: Case, stage: Stage, start: StereoRig, budget: Budget, seed: int) -> StageRun:
    """Run a stage from `start`.

    Raises:
        NeedNotMet: if the strategy needs what the stage's score does not offer.
        StrategyError: if the strategy crashes.
    """
    run = _count_stage if stage.score is ScoreKind.COUNT else _epipolar_stage
    done = run(case, stage, start, budget, seed)
    search, judging = sum(one.trace.total_cost for one in done.runs), sum(one.judging_cost for one in done.runs)
    return replace(done, cost=done.cost + Cost(search=search, judging=judging))


def _count_stage(case: Case, stage: Stage, start: StereoRig, budget: Budget, seed: int) -> StageRun:
    """Run a stage on the count over all that is free."""
    scale, chart = case.scale_of(stage), count_chart(case.rig, case.settings.reach, case.free)
    options = {"scale": scale, "rows": stage.rows, "frames": stage.frames, "budget": budget}
    objective = count_objective(case.images, case.matcher, chart, **options)
    at = np.clip(chart.coordinates_of(start), -1.0, 1.0)
    run = run_strategy(as_strategy(stage.strategy), objective, at, seed)
    return StageRun(stage, scale, start, chart.rig_at(run.best), (run,), _climb(run, chart))


def _climb(run: Run, chart: RigChart) -> tuple[Waypoint, ...]:
    """Each new best that was evaluated; strategies inside JAX evaluate none."""
    trace = run.trace
    values = np.where(np.isnan(trace.values), -np.inf, trace.values)
    best_before = np.maximum.accumulate(np.concatenate([[run.start_value], values]))[:-1]
    better = np.flatnonzero(values > best_before)
    return tuple(Waypoint(float(trace.cost[at]), np.asarray(chart.extrinsics(trace.points[at]))) for at in better)


def _epipolar_stage(case: Case, stage: Stage, start: StereoRig, budget: Budget, seed: int) -> StageRun:
    """Match, and fit; match again where the fit ended, until it settles."""
    scale, chart = case.scale_of(stage), case.chart
    data = case.images.at(scale, stage.frames)
    began, at, runs, rounds, found = time.perf_counter(), chart.coordinates_of(start), [], 0, None
    settled, cut = False, False

    def budget_left() -> Budget | None:
        return remaining(budget, rounds * data.cost + sum(run.trace.total_cost for run in runs), began)

    for _ in range(stage.rounds):
        allowed = budget_left()
        if allowed is None or (allowed.evaluations is not None and allowed.evaluations < data.cost):
            cut = found is None
            break
        found = matched(data, chart, at, case.matcher)
        rounds += 1
        if found.found < ENOUGH.matches:
            break
        before, groups = at, grouped(found, chart, at)
        for _ in range(_REWEIGHTED if len(groups) >= FEWEST_GROUPS else 0):
            residuals = linear_residuals(at, *rows_of_groups(groups, chart, at), chart.prior)
            if stage.strategy is None:  # costs nothing
                at = residuals.least
                continue
            if (allowed := budget_left()) is None:
                cut = True
                break
            runs.append(run_strategy(stage.strategy, epipolar_objective(residuals, allowed), at, seed))
            at, cut = runs[-1].best, runs[-1].status is Status.BUDGET
        settled = not cut and rows_moved(found, chart, before, at) < SETTLED
        if settled or cut:
            break
    ended, cost = chart.rig_at(at), Cost(correspondences=rounds * data.cost)
    return StageRun(stage, scale, start, ended, tuple(runs), (), cost, found, settled, cut)


def rows_moved(
    found: Correspondences, chart: RigChart, before: Float[np.ndarray, "n"], after: Float[np.ndarray, "n"]
) -> float:
    """How many pixels at full size the row differences of matches change between two points, on average: lenses may
    move those of a part of the view alone."""
    change = differences_at(found, chart, after) - differences_at(found, chart, before)
    return float(np.abs(change[np.asarray(found.weight) > 0]).mean()) / float(found.scale)


def last_matched(stages: Sequence[StageRun]) -> StageRun | None:
    """The last of some stages that has correspondences; None if none has."""
    return next((stage for stage in reversed(stages) if stage.found is not None), None)


def with_found(stages: Sequence[StageRun], found: Correspondences) -> tuple[StageRun, ...]:
    """The stages with other correspondences in the last one that has some."""
    last = last_matched(stages)
    return tuple(replace(one, found=found) if one is last else one for one in stages)


def matched(data: ScoringData, chart: RigChart, z: Float[np.ndarray, "n"], matcher: AbstractMatcher) -> Correspondences:
    """The correspondences under the rig at a point of the box, with the rays that the cameras of the chart's rig
    give."""
    rig, extrinsics = chart.rig_at(z), with_unit_baseline(chart.extrinsics(z))
    if same_cameras(rig, chart.rig):
        return host.correspondences(data, extrinsics, matcher)
    return with_rays_of(chart.rig, host.correspondences(data.through(rig), extrinsics, matcher), matched_rig=rig)


def remaining(budget: Budget, cost: float, began: float) -> Budget | None:
    """What may still be spent; None if that is nothing."""
    units = None if budget.evaluations is None else budget.evaluations - cost
    seconds = None if budget.seconds is None else budget.seconds - (time.perf_counter() - began)
    if (units is not None and units <= 0) or (seconds is not None and seconds <= 0):
        return None
    return Budget(units, seconds)


def path_of(initial: StereoRig, before: float, stages: Sequence[StageRun]) -> tuple[Waypoint, ...]:
    """Where a repair began, where each stage began and ended, and each new best of the stages on the count; `before`
    units were spent before the first stage."""
    spent, found = before, [Waypoint(0.0, np.asarray(initial.extrinsics))]
    for stage in stages:
        found.append(Waypoint(spent, np.asarray(stage.began.extrinsics)))
        found += [replace(one, cost=spent + one.cost) for one in stage.path]
        spent += stage.cost.budgeted
        found.append(Waypoint(spent, np.asarray(stage.ended.extrinsics)))
        spent += stage.cost.survey
    moves = [after for before, after in pairwise(found) if np.any(before.extrinsics != after.extrinsics)]
    return (found[0], *moves)
