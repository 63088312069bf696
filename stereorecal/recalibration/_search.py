"""The search of a repair: a survey that finds a start and the disparity range, then the stages of a schedule; at once,
or in slices, for those who cannot wait for all of it."""

import time
from dataclasses import dataclass, replace

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._schedule import Schedule, ScoreKind, Stage
from stereorecal.recalibration._settings import Settings, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solution_of import solution_of_search
from stereorecal.recalibration._stages import Extrinsics, StageRun, extrinsics_count_objective, remaining, run_stage
from stereorecal.scoring import host
from stereorecal.scoring.host import survey
from stereorecal.strategies import Budget

_YAW_ERROR_AFTER_EPIPOLAR = np.radians(0.25)  # at most, where yaw is observed
_SEED = 0  # of strategies that draw random numbers, in slices


def started(case: Case, schedule: Schedule) -> tuple[Case, StereoRig, Cost]:
    """What comes before the first stage: the case with a disparity range, where the stage begins, and what it took."""
    matcher, offset, of_survey = case.matcher, np.zeros(6), 0.0
    if schedule.survey or matcher.num_disparities is None:
        radians = float(np.radians(case.reach.degrees))
        surveyed = survey(case.images, case.rig.extrinsics, radians)
        case, of_survey = case.with_matcher(surveyed.with_range(matcher, radians)), surveyed.cost
        offset = surveyed.offset if schedule.survey else offset
    # Most repairs reach the epipolar stages: compile their scales while the start is sought.
    later = [case.scale_of(stage) for stage in schedule.stages if stage.score is ScoreKind.EPIPOLAR]
    for scale in dict.fromkeys(later):
        host.compile_in_background(case.images.sample(scale))
    start, of_starts = _better_start(case, schedule.stages[0], offset)
    return case, start, Cost(survey=of_survey, starts=of_starts)


def _better_start(case: Case, stage: Stage, offset: Extrinsics) -> tuple[StereoRig, float]:
    """The initial rig, or one with `offset` where the count at the scale of `stage` is higher; and what asking cost, in
    units."""
    initial = np.asarray(case.rig.extrinsics, float)
    if not offset.any():
        return case.rig, 0.0
    objective = extrinsics_count_objective(case, stage, Budget())
    chart = objective.images.chart
    moved = chart.inside(initial + offset)
    initial_count, moved_count = objective.problem.values(np.stack([chart.inside(initial), moved]))
    return (
        case.rig.with_extrinsics(chart.extrinsics(moved)) if moved_count > initial_count else case.rig
    ), 2 * objective.cost


def run_schedule(case: Case, settings: Settings, start: StereoRig, began: float) -> tuple[Case, tuple[StageRun, ...]]:
    """All stages that the budget allows; the case comes back with the widest disparity range that was measured.

    Args:
        began: when the clock of the budget was started.
    """
    schedule, measured = settings.schedule, settings.matcher.num_disparities is None
    widest, rig, stages = case, start, []
    for stage in schedule.stages:
        budget_left = remaining(settings.budget, sum(done.cost for done in stages), began)
        if budget_left is None:
            break
        done = run_stage(case, stage, rig, budget_left, settings.seed)
        rig = done.ended
        if len(schedule.stages) > 1 and measured:
            epipolar = stage.score is ScoreKind.EPIPOLAR
            yaw_error = float(_YAW_ERROR_AFTER_EPIPOLAR if epipolar else np.radians(case.reach.degrees))
            surveyed = survey(case.images, done.end_extrinsics, yaw_error, aligned=True)
            done = replace(done, survey_cost=surveyed.cost)
            case = case.with_matcher(surveyed.with_range(settings.matcher, yaw_error))
            # The decision matches under the initial rig too, which may need more disparities than the rig found.
            widest = max(widest, case, key=lambda c: c.matcher.num_disparities or 0)
        stages.append(done)
    return widest, tuple(stages)


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a repair is.

    Attributes:
        rig: where the next slice begins: the best so far.
        done: slices so far.
    """

    rig: StereoRig
    done: int = 0


def next_slice(case: Case, schedule: Schedule, at: Progress) -> Progress | Solution:
    """One slice more: first the survey, then a stage on the count, or one round of a stage on the rows, each begun
    where the one before it ended; the last one is judged with it.

    Args:
        case: with a disparity range.
        schedule: whose last stage has rows.
    """
    began = time.perf_counter()
    if at.done == 0:
        return Progress(started(case, schedule)[1], 1)
    stages = _rounds(schedule)
    stage = stages[at.done - 1]
    done = run_stage(case, stage, at.rig, Budget(), _SEED)
    if at.done < len(stages):
        return Progress(done.ended, at.done + 1)
    last = replace(schedule, stages=(stage,))
    settings = as_settings({"matcher": case.matcher, "schedule": last, "reach": case.reach})
    settings = replace(settings, free=case.free, tolerances=case.tolerances)
    return solution_of_search(case, settings, (done,), Cost(), began)


def _rounds(schedule: Schedule) -> tuple[Stage, ...]:
    """The stages, those on the rows cut into their rounds."""
    return tuple(
        replace(stage, rounds=1)
        for stage in schedule.stages
        for _ in range(stage.rounds if stage.score is ScoreKind.EPIPOLAR else 1)
    )
