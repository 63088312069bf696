"""What is told of a repair: from a judged candidate to the solution."""

import time
from dataclasses import replace

import numpy as np

from stereorecal.decision import Reason
from stereorecal.estimation import NO_RANGES
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._ending import Ending
from stereorecal.recalibration._ranges_of_case import ranges_seen
from stereorecal.recalibration._result import Findings, FramesUsed, SearchRun
from stereorecal.recalibration._settings import Settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import StageRun
from stereorecal.scoring.host import Score


def solution_of(
    case: Case, settings: Settings, stages: tuple[StageRun, ...], ending: Ending, cost: Cost, began: float
) -> Solution:
    """The solution.

    Args:
        case: what was judged; all that is free in it may move in the calibration to use.
        cost: of what came before the stages.
        began: when the clock was started.
    """
    reason = ending.reason
    if ending.found is not None:
        last = max(number for number, stage in enumerate(stages) if stage.found is not None)
        stages = tuple(replace(one, found=ending.found) if number == last else one for number, one in enumerate(stages))
    frames, whole = len(case.images.pairs), case.images.at(1.0)
    used = np.isin(np.arange(frames), ending.without, invert=True)
    pixels = whole.pixels * int(used.sum()) // frames  # all of one size
    before, after = (Score(int(found.sum()), pixels) for found in ending.tiles[:, used])
    excluded = tuple(case.images.pairs[frame].name for frame in ending.excluded)
    disagree = reason is Reason.FRAMES_DISAGREE
    matched_ranges = NO_RANGES if ending.estimate is None else ending.estimate.matched_ranges
    return Solution(
        initial=case.rig,
        candidate=ending.candidate,
        reason=reason,
        findings=Findings(
            score_before=before,
            score_after=after,
            row_errors=ending.row_errors,
            uncertainty=ending.uncertainty,
            misfit=ending.misfit,
            intrinsics=ending.intrinsics,
            ranges=ranges_seen(len(case.ranges), matched_ranges, case.rig, ending.candidate, reason),
            matched_ranges=matched_ranges,
            estimate=ending.estimate,
            decision=ending.decision,
            seen=ending.seen,
            mismatch=ending.mismatch,
        ),
        frames=FramesUsed(
            selected=case.selected,
            used=tuple(np.flatnonzero(used).tolist()),
            left_out=() if disagree else excluded,
            disagreeing=excluded if disagree else (),
        ),
        search=SearchRun(
            view=case.images.view,
            matcher=case.matcher,
            stages=stages,
            status=ending.status,
            message=ending.message,
            cost=Cost(
                survey=cost.survey + sum(stage.survey_cost for stage in stages),
                starts=cost.starts,
                search=sum(stage.search_cost for stage in stages),
                correspondences=sum(stage.matching_cost for stage in stages),
                judging=sum(stage.judging_cost for stage in stages) + ending.judging_cost + 2 * whole.cost,
            ),
            seconds=time.perf_counter() - began,
        ),
        settings=settings,
        prior_use=case.prior_use,
    )
