"""The repair of a rig: prepare, search, estimate, decide, report; and one look at the images, without any search: will
depth be right?"""

import time
from dataclasses import replace
from typing import Unpack

from stereorecal._arrays import refuse_tracers
from stereorecal.decision import ENOUGH
from stereorecal.estimation import is_exact, one_blas_thread
from stereorecal.geometry import StereoRig, checked_rig
from stereorecal.objectives import Parameters
from stereorecal.recalibration._assessment import assessed
from stereorecal.recalibration._case import Case, chosen_frames
from stereorecal.recalibration._match_ranges import resolved_ranges
from stereorecal.recalibration._motion_windows import check_motion, check_odometer, following
from stereorecal.recalibration._prior_use import prior_of, prior_use
from stereorecal.recalibration._schedule import check_schedule
from stereorecal.recalibration._search import run_schedule, solution_of_search
from stereorecal.recalibration._settings import HealthOptions, RepairOptions, Settings, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import run_look, started
from stereorecal.recordings import Pairs
from stereorecal.scoring import pyramid

# Beside the tolerances.
HEALTH_LIMITS = {"covered": ENOUGH.covered, "covered_of_texture": ENOUGH.of_texture, "by_chance": ENOUGH.by_chance}


def what_may_change(rig: StereoRig, settings: Settings) -> Parameters:
    """The parameters that may change in the end: those that are named; by default every one of the rig, or, where the
    intrinsics are exact or only the count is asked, the extrinsics."""
    intrinsics = bool(settings.schedule.on_rows) and not is_exact(settings.prior)
    return settings.free.of_all(rig, intrinsics=intrinsics)


def prepared(rig: StereoRig, pairs: Pairs, settings: Settings, *, learns: bool = True) -> Case:
    """The case of a repair, of whose strategies the extrinsics are asked. Where it learns, a prior is to follow: pairs
    that a saved one rests on do not count again then.

    Raises:
        InputError: as `recalibrate`.
    """
    settings = replace(settings, free=what_may_change(rig, settings))
    images, free = pyramid(rig, pairs, settings.view), settings.free
    free.check(rig)
    ranges = resolved_ranges(settings.ranges, [("", images.pairs)])
    check_schedule(settings.schedule, free)
    check_motion(settings.motion, len(images.pairs), settings.prior)
    use = prior_use(settings.prior, rig, images.pairs, learns=learns)
    numbers = use.numbers
    if free.shared:
        chosen = chosen_frames([images.pairs[number] for number in numbers])
        wanted = {id(pair) for pair in (*chosen, *(one.pair for one in ranges))}
        numbers = tuple(number for number in numbers if id(images.pairs[number]) in wanted)
    if len(numbers) < len(images.pairs):
        images = pyramid(rig, [images.pairs[number] for number in numbers], images.view)
    measured = bool(ranges) or settings.odometer is not None
    known = prior_of(use.prior, free, rig, settings.reach, ranges=measured)
    windows = following(images.pairs, numbers, settings.motion, known)
    check_odometer(settings.odometer, images.pairs, windows)
    return Case(images, settings, settings.matcher, free.extrinsics, known, ranges, windows, use, numbers)


def recalibrate(rig: StereoRig, pairs: Pairs, **options: Unpack[RepairOptions]) -> Solution:
    """Repair the calibration of a rig from image pairs that it took.

    Args:
        rig: the calibration to start from.
        pairs: one or several frames, used jointly; a pair may be a tuple of two arrays.
        options: those of `RepairOptions`, by name.

    Raises:
        InputError: if images and calibration do not fit, a strategy of the schedule is not installed, the prior makes
            no sense, belongs to another rig, or rests on all these pairs already, or there is nothing that
            could move.
        StrategyError: if a strategy crashes.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.recalibrate", "sr.count, sr.soft_count or sr.row_differences and an optimiser of yours", rig)
    began = time.perf_counter()
    return recalibrate_case(prepared(checked_rig(rig), pairs, as_settings(options)), began)


@one_blas_thread()
def recalibrate_case(case: Case, began: float | None = None) -> Solution:
    """The repair of what is prepared: a look, as `health` has it, and a search where that does not settle, or would see
    more.

    Args:
        case: its strategies search all that is free in it, intrinsics too, which `recalibrate` leaves to the estimate;
            its matcher may lack `num_disparities`, which is then measured.
        began: when the clock was started; default now.

    Raises:
        NeedNotMet: if a strategy needs what a score does not offer over this box.
        StrategyError: if a strategy crashes.
    """
    began = time.perf_counter() if began is None else began
    case, start, cost = started(case)
    if on_rows := case.settings.schedule.on_rows:
        run, cost = run_look(case, on_rows, start, cost)
        found, cost = assessed(case, (run,), cost, began, conclusive=True) if run.settled else (None, cost)
        if found is not None:
            return found
    case, stages = run_schedule(case, start, began)
    cut = len(stages) < len(case.settings.schedule.stages)
    return solution_of_search(case, stages, cost, began, cut=cut)


@one_blas_thread()
def health(rig: StereoRig, pairs: Pairs, **options: Unpack[HealthOptions]) -> Solution:
    """Look at the pairs, from the start that a survey of the rotation found, and estimate the correction that they ask
    for: `solution.condition` says whether the calibration is good, `solution.rig` is what a repair would come to.

    `recalibrate` begins with the same look, and searches where it does not settle.

    Args:
        options: those of `HealthOptions`, by name. Pairs that a saved prior rests on count, for nothing is learnt here.

    Raises:
        InputError: if images and calibration do not fit, the images are no left and right image of this rig, the
            prior makes no sense, or nothing can have moved.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    began, settings = time.perf_counter(), as_settings(options, HealthOptions.__optional_keys__)
    case, start, cost = started(prepared(checked_rig(rig), pairs, settings, learns=False))
    run, cost = run_look(case, settings.schedule.stages, start, cost)
    found = solution_of_search(case, (run,), cost, began)
    return replace(found, searched=False, message="one look at the images, without a search")
