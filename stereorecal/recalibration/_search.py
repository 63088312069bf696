"""The search of a repair: through the stages of a schedule."""

from dataclasses import replace

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._schedule import ScoreKind
from stereorecal.recalibration._settings import Settings
from stereorecal.recalibration._stages import StageRun, remaining, run_stage
from stereorecal.scoring.host import survey

_YAW_ERROR_AFTER_EPIPOLAR = np.radians(0.25)  # at most, where yaw is observed


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
