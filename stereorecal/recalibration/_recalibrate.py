"""The repair of a rig: prepare, search, estimate, decide, report."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Unpack

from stereorecal._arrays import refuse_tracers
from stereorecal.decision import Verdict
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._acceptance import Reason
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._ending import Ending
from stereorecal.recalibration._ending_of_search import ending_of
from stereorecal.recalibration._initial_assessment import InitialAssessment, assess_initial_rig
from stereorecal.recalibration._prepared_case import prepared
from stereorecal.recalibration._search import run_schedule
from stereorecal.recalibration._search_start import started
from stereorecal.recalibration._settings import RepairOptions, Settings, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solution_of import solution_of
from stereorecal.recalibration._stages import StageRun, last_matched
from stereorecal.recordings import Pairs


def recalibrate(rig: StereoRig, pairs: Pairs, **options: Unpack[RepairOptions]) -> Solution:
    """Repair the extrinsics of a rig from image pairs that it took.

    Args:
        rig: the calibration to start from.
        pairs: one or several frames, used jointly; a pair may be a tuple of two arrays.
        options: those of `RepairOptions`, by name: `matcher, schedule, reach, budget, view, seed, free, ranges, prior,
            boards, motion, tolerances, odometer`.

    Raises:
        InputError: if images and calibration do not fit, a strategy of the schedule is not installed, the prior makes
            no sense, belongs to another rig, or rests on all these pairs already, or the boards do not fit the
            calibration, or there is nothing that could move.
        StrategyError: if a strategy crashes.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.recalibrate", "sr.count, sr.soft_count or sr.row_differences and an optimiser of yours", rig)
    began, settings = time.perf_counter(), as_settings(options)
    return recalibrate_case(prepared(rig, pairs, settings), settings, began)


def recalibrate_case(case: Case, settings: Settings, began: float | None = None) -> Solution:
    """The repair of what is prepared.

    It looks before it searches, as `health` does: what one look finds good stays, and what a look is sure to correct is
    corrected, unless the search corrects more, or saw more and ends in doubt.

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
    schedule = settings.schedule

    # Prepare: the disparity range, where to start, the initial assessment.
    case, start, cost = started(case, schedule)
    to_decide = case.with_free(settings.free)
    initial = assess_initial_rig(to_decide, schedule.stages[-1])
    if initial is not None:
        cost = replace(cost, starts=cost.starts + initial.cost)  # outside the budget, as all before the search
        if initial.verdict is Verdict.GOOD:
            ending = initial.ending(to_decide)
            return solution_of(to_decide, settings, (initial.run_at_no_cost,), ending, cost, began)

    # Search; estimate and decide; the initial assessment, where that left doubt.
    case, stages = run_schedule(case, settings, start, began)
    to_decide = case.with_free(settings.free)
    ending = ending_of(to_decide, schedule, stages)
    if initial is not None and initial.repairs and not search_stands(ending, stages, initial):
        ending = replace(initial.ending(to_decide), judging_cost=ending.judging_cost)
        stages = (*stages, initial.run_at_no_cost)

    # Report.
    return solution_of(to_decide, settings, stages, ending, cost, began)


def search_stands(ending: Ending, stages: Sequence[StageRun], initial: InitialAssessment) -> bool:
    """Whether what the search ended with is kept, though a look is sure of a repair: a repair that explains the rows,
    or, where the look's does not either, has no larger row error or leaves it to intrinsics; and doubt, if it comes of
    more that matches."""
    if ending.reason is Reason.OUT_OF_BUDGET:
        return True  # it accepts nothing: the search that might have contradicted the look was not finished
    if not ending.reason.accepted:
        run = last_matched(stages)
        return run is not None and run.found is not None and run.found.covered > initial.covered
    decision = ending.decision
    if decision is None or decision.explains:
        return True
    no_larger = float(decision.rows_px[1, 0]) <= initial.row_error
    return not initial.explains and (decision.left_to_intrinsics or no_larger)
