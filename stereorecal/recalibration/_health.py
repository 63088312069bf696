"""Will depth be right? One look at the images through a calibration, without any search."""

import time
from dataclasses import replace
from typing import Unpack

from stereorecal._arrays import refuse_tracers
from stereorecal.decision import ENOUGH, LIMITS
from stereorecal.estimation import one_blas_thread
from stereorecal.geometry import StereoRig, checked_rig
from stereorecal.recalibration._assessment import run_look
from stereorecal.recalibration._prepared_case import prepared, what_may_change
from stereorecal.recalibration._search import started
from stereorecal.recalibration._settings import HealthOptions, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solution_of import solution_of_search
from stereorecal.recordings import Pairs

HEALTH_LIMITS = {"covered": ENOUGH.covered, "covered_of_texture": ENOUGH.of_texture, **LIMITS}


@one_blas_thread()
def health(rig: StereoRig, pairs: Pairs, **options: Unpack[HealthOptions]) -> Solution:
    """Match the pairs under the rig's calibration, and estimate once the correction that they ask for:
    `solution.condition` says whether the calibration is good, `solution.change` what would mend it.

    `recalibrate` begins with the same look: what is healthy here stays there, what is to be repaired here is repaired.

    Args:
        options: those of `HealthOptions`, by name: `matcher, view, prior, motion, tolerances, distances`. Pairs that a
            saved prior rests on count, for nothing is learnt here.

    Raises:
        InputError: if images and calibration do not fit, the images are no left and right image of this rig, the
            prior makes no sense, or nothing can have moved.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    rig = checked_rig(rig)
    began, settings = time.perf_counter(), as_settings(options, HealthOptions.__optional_keys__)
    look = replace(settings.schedule, stages=settings.schedule.stages[-1:], survey=False)
    settings = replace(settings, free=what_may_change(rig, settings), schedule=look)
    case, _, cost = started(prepared(rig, pairs, settings, learns=False), look)
    case = case.with_free(settings.free)
    run = run_look(case, look.stages[0])
    found = solution_of_search(case, settings, (run,), cost, began)
    return replace(found, searched=False, message="one look at the images, without a search")
