"""The entry point: validate, run the schedule, judge its end."""

import time
from collections.abc import Sequence

import numpy as np

from stereorecal.geometry import Pair, StereoRig, View, check_pairs, view as default_view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.recalibration._schedule import Schedule
from stereorecal.recalibration._solution import Reason, Solution
from stereorecal.scoring import Score, counts, normalised, prepare, with_disparity_range
from stereorecal.strategies import (
    Budget,
    Reach,
    Status,
    chart_around,
    objective,
    run_strategy,
    strategy,
)


def recalibrate(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    matcher: AbstractMatcher | None = None,
    schedule: Schedule | None = None,
    reach: Reach | None = None,
    budget: Budget | None = None,
    view: View | None = None,
    seed: int = 0,
) -> Solution:
    """Repair the extrinsics of a rig from image pairs that it took.

    Args:
        rig: the calibration to start from.
        pairs: one or several frames; their counts add up.
        matcher: default `SAD()`; without `num_disparities` the range is measured.
        schedule: default `Schedule.count(strategy("compass"))`.
        reach: how far the rig may have drifted; default 3 degrees and 3 % of the baseline.
        budget: limits for the whole schedule; default none.
        view: default the view of `rig`.
        seed: for strategies that draw random numbers.

    Raises:
        InputError: if images and calibration do not fit, or the default strategy is not installed.
        StrategyError: if a strategy crashes.
    """
    pairs = check_pairs(rig, list(pairs))
    schedule = schedule or Schedule.count(strategy("compass"))
    reach, budget = reach or Reach(), budget or Budget()
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, pairs, view, np.radians(reach.degrees))
    chart = chart_around(rig, reach)

    began = time.perf_counter()
    best, runs = np.zeros(chart.dim), []
    for stage in schedule.stages:
        stage_objective = objective(rig, pairs, matcher=matcher, reach=reach, view=view, scale=stage.scale)
        left = _left(budget, sum(run.trace.total_cost for run in runs), began)
        runs.append(run_strategy(stage.strategy, stage_objective, best, left, seed))
        best = runs[-1].best
    seconds, last = time.perf_counter() - began, runs[-1]

    candidate = rig.with_extrinsics(chart.extrinsics(best))
    data = prepare(rig, pairs, view)
    judged = counts(data, np.stack([normalised(r.extrinsics) for r in (rig, candidate)]), matcher)
    before, after = (Score(int(found), data.pixels) for found in judged)
    accepted = after.count > before.count
    if accepted:
        reason = Reason.IMPROVED
    else:
        reason = Reason.TOO_LITTLE_TEXTURE if last.status is Status.NO_SIGNAL else Reason.NOT_IMPROVED
    return Solution(
        rig=candidate if accepted else rig,
        candidate=candidate,
        initial=rig,
        accepted=accepted,
        reason=reason,
        status=last.status,
        message=last.message,
        view=view,
        matcher=matcher,
        score_before=before,
        score_after=after,
        trace=last.trace,
        evaluations=sum(len(run.trace.values) for run in runs),
        cost=sum(run.trace.total_cost for run in runs),
        seconds=seconds,
    )


def _left(budget: Budget, cost: float, began: float) -> Budget:
    """What a later stage may still spend; at least a trace of it, so that its judge can speak."""
    tiny = 1e-12
    units = None if budget.evaluations is None else max(tiny, budget.evaluations - cost)
    seconds = None if budget.seconds is None else max(tiny, budget.seconds - (time.perf_counter() - began))
    return Budget(units, seconds)
