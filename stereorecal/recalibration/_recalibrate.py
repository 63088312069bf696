"""The repair of a rig: prepare, search, estimate, decide, report."""

import time
from dataclasses import replace
from typing import Unpack

from stereorecal._arrays import refuse_tracers
from stereorecal.estimation import one_blas_thread
from stereorecal.geometry import StereoRig, checked_rig
from stereorecal.recalibration._assessment import assessed, run_look
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._prepared_case import prepared, what_may_change
from stereorecal.recalibration._schedule import ScoreKind
from stereorecal.recalibration._search import run_schedule, started
from stereorecal.recalibration._settings import RepairOptions, Settings, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solution_of import solution_of_assessment, solution_of_search
from stereorecal.recordings import Pairs


def recalibrate(rig: StereoRig, pairs: Pairs, **options: Unpack[RepairOptions]) -> Solution:
    """Repair the calibration of a rig from image pairs that it took.

    Args:
        rig: the calibration to start from.
        pairs: one or several frames, used jointly; a pair may be a tuple of two arrays.
        options: those of `RepairOptions`, by name: `matcher, schedule, reach, budget, view, seed, free, ranges, prior,
            motion, tolerances, distances, odometer`.

    Raises:
        InputError: if images and calibration do not fit, a strategy of the schedule is not installed, the prior makes
            no sense, belongs to another rig, or rests on all these pairs already, or there is nothing that
            could move.
        StrategyError: if a strategy crashes.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.recalibrate", "sr.count, sr.soft_count or sr.row_differences and an optimiser of yours", rig)
    rig = checked_rig(rig)
    began, settings = time.perf_counter(), as_settings(options)
    settings = replace(settings, free=what_may_change(rig, settings))
    return recalibrate_case(prepared(rig, pairs, settings), settings, began)


@one_blas_thread()
def recalibrate_case(case: Case, settings: Settings, began: float | None = None) -> Solution:
    """The repair of what is prepared.

    It looks before it searches, as `health` does; where that look sees what a search would see, it is the answer.

    Args:
        case: its strategies search all that is free in it, intrinsics too, which `recalibrate` leaves to the estimate;
            its matcher may lack `num_disparities`, which is then measured.
        settings: `free` is what may change in the end.
        began: when the clock was started; default now.

    Raises:
        NeedNotMet: if a strategy needs what a score does not offer over this box.
        StrategyError: if a strategy crashes.
    """
    began = time.perf_counter() if began is None else began
    case, start, cost = started(case, settings.schedule)
    to_decide = case.with_free(settings.free)
    if (last := settings.schedule.stages[-1]).score is ScoreKind.EPIPOLAR:
        run = run_look(to_decide, last)
        assessment = assessed(to_decide, run, run.ended)
        cost = replace(cost, starts=cost.starts + run.cost)  # outside the budget, as all before the search
        if assessment is not None and assessment.conclusive:
            run = replace(run, matching_cost=0.0)
            return solution_of_assessment(to_decide, settings, (run,), assessment, cost, began)
    case, stages = run_schedule(case, settings, start, began)
    return solution_of_search(case.with_free(settings.free), settings, stages, cost, began)
