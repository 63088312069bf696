"""The search of a repair: a survey that finds a start and the disparity range, then the stages of a schedule; at once,
or in slices, for those who cannot wait for all of it; and the solution that its end, or a look at the images, comes
to."""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Int

from stereorecal.decision import Reason, Seen, reason_of
from stereorecal.estimation import NO_RANGES, Estimate
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._assessment import Assessment, assessed, counts
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import RangesSeen
from stereorecal.recalibration._mismatch import mismatch_of
from stereorecal.recalibration._row_residuals import misfit, row_residuals
from stereorecal.recalibration._schedule import Schedule, ScoreKind, Stage, watching_scale
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import (
    Cost,
    StageRun,
    last_matched,
    matched,
    remaining,
    run_stage,
    started,
)
from stereorecal.recalibration._uncertainty import IntrinsicsOutcome, intrinsics_of, uncertainty_of
from stereorecal.scoring.host import Score, survey
from stereorecal.strategies import Budget, Status

_YAW_ERROR_AFTER_EPIPOLAR = np.radians(0.25)  # at most, where yaw is observed
_SEED = 0  # of strategies that draw random numbers, in slices


def solution_of_search(
    case: Case, stages: tuple[StageRun, ...], cost: Cost, began: float, *, cut: bool = False
) -> Solution:
    """The solution that the stages of a schedule come to, judged by matches, or, where there are none, by the count.

    Args:
        case: with all that may change free, which then may move in the calibration to use.
        stages: that were run.
        cost: of what came before the stages.
        began: when the clock was started.
        cut: whether the budget ended before all stages were run.
    """
    status, message = _ending(stages)
    if cut := cut or any(stage.cut for stage in stages):
        status, message = Status.BUDGET, Status.BUDGET.value
    end_rig = stages[-1].ended if stages else case.rig
    run = last_matched(stages)
    assessment = None if cut or run is None else assessed(case, run, end_rig)
    if assessment is not None:
        found = solution_of_assessment(case, stages, assessment, cost, began)
        return replace(found, status=status, message=message)
    tiles, mismatch = counts(case, end_rig), None
    before, after = tiles.sum(axis=(1, 2)).tolist()
    if cut or run is not None:  # the count alone hardly sees a wrong yaw
        reason = reason_of(None, Seen(enough=case.images.enough, cut=cut))
        if not cut and run is not None and run.found is not None:
            mismatch = mismatch_of(case.images, case.matcher, run.found.covered)
    elif status is Status.NO_SIGNAL:
        reason = Reason.TOO_LITTLE_TEXTURE
    else:
        reason = Reason.MORE_MATCHES if after > before else Reason.NOT_IMPROVED
    found = _solution(case, stages, end_rig, reason, tiles, cost, began, mismatch=mismatch)
    return replace(found, status=status, message=message)


def _ending(stages: tuple[StageRun, ...]) -> tuple[Status, str]:
    """How the last stage ended, in its strategy's words where it has one."""
    last = stages[-1] if stages else None
    if last is not None and last.runs:
        return last.runs[-1].status, last.runs[-1].message
    if last is None or not last.matches_enough:
        return Status.NO_SIGNAL, Status.NO_SIGNAL.value
    if not last.settled:
        return Status.STALLED, "the rounds ended before matches and fit had settled"
    return Status.CONVERGED, "matches and fit have settled"


def solution_of_assessment(
    case: Case, stages: tuple[StageRun, ...], assessment: Assessment, cost: Cost, began: float
) -> Solution:
    """The solution that an assessment of the matches of the last stage comes to; the arguments are those of
    `solution_of_search`."""
    last = max(number for number, stage in enumerate(stages) if stage.found is not None)
    estimated, candidate, found = assessment.estimate, assessment.candidate, assessment.found
    seen, reason = assessment.seen, assessment.reason
    covered = seen.covered
    if not reason.healthy:  # a candidate that is refused may match by what it should not change
        covered = min(covered, _covered_at(case, stages[last].began))
    if mismatch := mismatch_of(case.images, case.matcher, covered):
        seen = replace(seen, wrong_input=True)
        reason = reason_of(assessment.decision, seen)
    rows, shared = row_residuals(case.chart, found, candidate), case.free.shared
    return _solution(
        case,
        tuple(replace(one, found=found) if number == last else one for number, one in enumerate(stages)),
        candidate,
        reason,
        assessment.tiles,
        replace(cost, judging=cost.judging + assessment.matching_cost),
        began,
        excluded=assessment.excluded,
        row_errors=rows.errors,
        uncertainty=uncertainty_of(estimated, candidate, case.with_free(case.free.without_intrinsics).chart),
        misfit=misfit(rows, late=estimated.is_late),
        intrinsics=intrinsics_of(estimated, assessment.decision.theta, shared, IntrinsicsOutcome.REFINED)
        if reason.accepted and shared
        else None,
        estimate=estimated,
        decision=assessment.decision,
        seen=seen,
        mismatch=mismatch,
    )


def _covered_at(case: Case, rig: StereoRig) -> float:
    """The share that matches under a rig, at half scale: at full scale, one that is degrees off covers as little as one
    with other cameras."""
    data, chart = case.images.at(watching_scale(case.rig.left.size)), case.chart
    return matched(data, chart, chart.coordinates_of(rig), case.matcher).covered


def _solution(
    case: Case,
    stages: tuple[StageRun, ...],
    candidate: StereoRig,
    reason: Reason,
    tiles: Int[np.ndarray, "2 k tiles"],
    cost: Cost,
    began: float,
    *,
    excluded: tuple[int, ...] = (),
    estimate: Estimate | None = None,
    **findings: Any,
) -> Solution:
    """The solution with a candidate, accepted or not.

    Args:
        tiles: counts at full scale of all frames, under the initial calibration and the candidate.
        excluded: numbers of the frames that show another rig than the others; all of them count all the same where they
            are too many to say which are wrong.
        findings: what else is found, as `Solution` names it.
    """
    disagree = reason is Reason.FRAMES_DISAGREE
    frames, whole = len(case.images.pairs), case.images.at(1.0)
    used = np.isin(np.arange(frames), () if disagree else excluded, invert=True)
    pixels = whole.pixels * int(used.sum()) // frames  # all of one size
    before, after = (Score(int(found.sum()), pixels) for found in tiles[:, used])
    names = tuple(case.images.pairs[frame].name for frame in excluded)
    matched_ranges = NO_RANGES if estimate is None else estimate.matched_ranges
    return Solution(
        initial=case.rig,
        candidate=candidate,
        reason=reason,
        score_before=before,
        score_after=after,
        used=tuple(np.flatnonzero(used).tolist()),
        shown=case.images.best_quality,
        view=case.images.view,
        matcher=case.matcher,
        stages=stages,
        status=Status.CONVERGED,
        message="one look at the images was enough",
        cost=Cost(
            survey=cost.survey + sum(stage.survey_cost for stage in stages),
            starts=cost.starts,
            search=sum(stage.search_cost for stage in stages),
            correspondences=sum(stage.matching_cost for stage in stages),
            judging=sum(stage.judging_cost for stage in stages) + cost.judging + 2 * whole.cost,
        ),
        seconds=time.perf_counter() - began,
        settings=case.settings,
        selected=case.selected,
        left_out=() if disagree else names,
        disagreeing=names if disagree else (),
        ranges=RangesSeen.of(len(case.ranges), matched_ranges, case.rig, candidate, reason),
        estimate=estimate,
        prior_use=case.prior_use,
        **findings,
    )


def run_schedule(case: Case, start: StereoRig, began: float) -> tuple[Case, tuple[StageRun, ...]]:
    """All stages that the budget allows; the case comes back with the widest disparity range that was measured; the
    clock of the budget was started when it `began`."""
    settings = case.settings
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
            yaw_error = float(_YAW_ERROR_AFTER_EPIPOLAR if epipolar else np.radians(case.settings.reach.degrees))
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


def next_slice(case: Case, at: Progress) -> Progress | Solution:
    """One slice more: first the survey, then a stage on the count, or one round of a stage on the rows, each begun
    where the one before it ended; the last one is judged with it. The case has a disparity range, and a schedule whose
    last stage has rows."""
    began, schedule = time.perf_counter(), case.settings.schedule
    if at.done == 0:
        return Progress(started(case)[1], 1)
    stages = _rounds(schedule)
    stage = stages[at.done - 1]
    done = run_stage(case, stage, at.rig, Budget(), _SEED)
    if at.done < len(stages):
        return Progress(done.ended, at.done + 1)
    return solution_of_search(case, (done,), Cost(), began)


def _rounds(schedule: Schedule) -> tuple[Stage, ...]:
    """The stages, those on the rows cut into their rounds."""
    numbers = [(one, one.rounds if one.score is ScoreKind.EPIPOLAR else 1) for one in schedule.stages]
    return tuple(replace(stage, rounds=1) for stage, number in numbers for _ in range(number))
