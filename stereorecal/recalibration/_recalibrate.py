"""The entry point: validate, run the schedule, judge its end."""

import time
from collections.abc import Sequence

import numpy as np

from stereorecal.geometry import StereoRig, View, view as default_view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration._acceptance import Reason, row_errors, verdict, verdict_on_count
from stereorecal.recalibration._evidence import evidence
from stereorecal.recalibration._schedule import Schedule, ScoreKind
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import FEWEST, Case, StageRun, better_start, remaining, run_stage
from stereorecal.recalibration._uncertainty import uncertainty
from stereorecal.recordings import Pair, check_pairs
from stereorecal.scoring import Score, counts_one_by_one, normalised, prepare, survey, with_disparity_range
from stereorecal.strategies import Budget, Status

_YAW_LEFT = np.radians(0.25)  # what an epipolar stage leaves, where yaw is observed


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
        pairs: one or several frames, used jointly.
        matcher: default `SAD()`; without `num_disparities` the range is measured, and again as the rig comes right.
        schedule: default `Schedule.default()`: coarse to fine, the count and then epipolar residuals.
        reach: how far the rig may have drifted; default 3 degrees and 3 % of the baseline.
        budget: limits for the whole schedule; default none.
        view: default the view of `rig`.
        seed: for strategies that draw random numbers.

    Raises:
        InputError: if images and calibration do not fit, or a strategy of the default schedule is not installed.
        StrategyError: if a strategy crashes.
    """
    began = time.perf_counter()
    pairs = check_pairs(rig, list(pairs))
    schedule = schedule or Schedule.default()
    reach, budget = reach or Reach(), budget or Budget()
    view = default_view(rig) if view is None else view
    asked, radians = matcher or SAD(), np.radians(reach.degrees)
    start, survey_cost = np.zeros(6), 0.0
    if schedule.survey:
        seen = survey(rig, pairs, view, radians)
        ranged, start, survey_cost = seen.with_range(asked, radians), seen.offset, seen.cost
    else:
        ranged = with_disparity_range(asked, rig, pairs, view, radians)
    case = Case(rig, pairs, ranged, view, reach)
    case, stages = _run_schedule(case, schedule, asked, start, budget, seed)
    return _judged(case, stages, survey_cost, began)


def _run_schedule(
    case: Case, schedule: Schedule, asked: AbstractMatcher, start: np.ndarray, budget: Budget, seed: int
) -> tuple[Case, tuple[StageRun, ...]]:
    """All stages; the case comes back with the widest disparity range that was measured."""
    began, stages, widest = time.perf_counter(), [], case
    best = better_start(case, schedule.stages[0], np.asarray(case.chart.coordinates(case.rig.extrinsics + start)))
    for stage in schedule.stages:
        left = remaining(budget, sum(done.cost for done in stages), began) or Budget(_TRACE_OF_A_BUDGET)
        stages.append(run_stage(case, stage, best, left, seed))
        best = stages[-1].best
        if len(schedule.stages) > 1 and asked.num_disparities is None:
            yaw_left = _YAW_LEFT if stage.score is ScoreKind.EPIPOLAR else np.radians(case.reach.degrees)
            seen = survey(case.rig_at(best), case.pairs, case.view, yaw_left, aligned=True)
            case = case.with_matcher(seen.with_range(asked, yaw_left))
            widest = max(widest, case, key=lambda c: c.matcher.num_disparities or 0)
    return widest, tuple(stages)


_TRACE_OF_A_BUDGET = 1e-12  # so that a stage's judge can speak even when nothing may be spent


def _judged(case: Case, stages: tuple[StageRun, ...], survey_cost: float, began: float) -> Solution:
    best, runs = stages[-1].best, [run for stage in stages for run in stage.runs]
    found = next((stage.found for stage in reversed(stages) if stage.found is not None), None)
    candidate = case.rig_at(best)
    before, after = _scores(case, candidate)
    status, message = (runs[-1].status, runs[-1].message) if runs else (Status.NO_SIGNAL, Status.NO_SIGNAL.value)
    cut = any(stage.cut for stage in stages)
    if cut:
        status, message = Status.BUDGET, Status.BUDGET.value
    rows = known = None
    if cut:
        reason = Reason.OUT_OF_BUDGET  # the count alone would let harm through: it hardly sees a wrong yaw
    elif found is None:
        reason = verdict_on_count(before, after, signal=status is not Status.NO_SIGNAL)
    elif found.found < FEWEST:
        reason = Reason.TOO_LITTLE_TEXTURE
    else:
        facts = evidence(case, found, best)
        rows, known = row_errors(facts), uncertainty(facts.covariance(), case.chart)
        reason = verdict(before, after, rows, best, known.observed, facts.places, found.covered, len(case.pairs))
    accepted = reason in (Reason.IMPROVED, Reason.MORE_MATCHES)
    return Solution(
        rig=candidate if accepted else case.rig,
        candidate=candidate,
        initial=case.rig,
        accepted=accepted,
        reason=reason,
        status=status,
        message=message,
        view=case.view,
        matcher=case.matcher,
        reach=case.reach,
        survey_cost=survey_cost,
        score_before=before,
        score_after=after,
        row_errors=rows,
        uncertainty=known,
        stages=stages,
        seconds=time.perf_counter() - began,
    )


def _scores(case: Case, candidate: StereoRig) -> tuple[Score, Score]:
    """Counts at full scale, before and after; the judge's own work, which no budget pays for."""
    data = prepare(case.rig, case.pairs, case.view)
    judged = counts_one_by_one(data, np.stack([normalised(r.extrinsics) for r in (case.rig, candidate)]), case.matcher)
    before, after = (Score(int(found), data.pixels) for found in judged)
    return before, after
