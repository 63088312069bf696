"""Where the search of a repair starts, and its disparity range."""

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._schedule import Schedule, ScoreKind, Stage
from stereorecal.recalibration._stages import Extrinsics, extrinsics_count_objective
from stereorecal.scoring import host
from stereorecal.scoring.host import survey
from stereorecal.strategies import Budget


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
