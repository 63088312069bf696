"""The entry point: validate, run the schedule, judge its end."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stereorecal._arrays import refuse_tracers
from stereorecal.decision import Tolerances, Verdict, as_tolerances
from stereorecal.estimation import NO_BEAMS, Prior, rig_parameters, with_boards
from stereorecal.geometry import AnyView, StereoRig
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.objectives import Parameters, Reach, as_parameters, as_reach
from stereorecal.recalibration._acceptance import Reason, verdict_on_count
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._estimated import answered, ended_by, looked
from stereorecal.recalibration._frame_choice import looked_at
from stereorecal.recalibration._prior_use import prior_use
from stereorecal.recalibration._ranged import prior_of, ranges_seen
from stereorecal.recalibration._ranges import resolved_ranges, with_ranges
from stereorecal.recalibration._request import Asked
from stereorecal.recalibration._schedule import Schedule, ScoreKind, as_schedule, check_schedule
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stage_result import Ending, counts
from stereorecal.recalibration._stages import FEWEST, Case, StageRun, better_start, remaining, run_stage
from stereorecal.recalibration._windows import check_motion, check_odometer, following
from stereorecal.recordings import Board, Odometer, Pairs, Range
from stereorecal.scoring import host, image_quality, pyramid
from stereorecal.scoring.host import Score, survey
from stereorecal.strategies import Budget, Status, as_budget

_YAW_LEFT = np.radians(0.25)  # what an epipolar stage leaves, where yaw is observed


def recalibrate(
    rig: StereoRig,
    pairs: Pairs,
    *,
    matcher: AbstractMatcher | str | None = None,
    schedule: Schedule | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    budget: Budget | float | None = None,
    view: AnyView = None,
    seed: int = 0,
    free: Parameters | str | Sequence[str] | None = None,
    ranges: Sequence[Range] = (),
    prior: Prior = None,
    boards: Sequence[Board] | None = None,
    motion: bool | None = None,
    tolerances: Tolerances | Mapping[str, object] | None = None,
    odometer: Odometer | None = None,
) -> Solution:
    """Repair the extrinsics of a rig from image pairs that it took.

    Args:
        rig: the calibration to start from.
        pairs: one or several frames, used jointly; a pair may be a tuple of two arrays.
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` the range is
            measured, and again as the rig comes right.
        schedule: a `Schedule`, or "default" (also for None): coarse to fine, the count and then epipolar residuals; or
            "count": compass search on the count at full scale, the paper's way.
        reach: how far the rig may have drifted, a `Reach` or (degrees, fraction of the baseline); default 3 degrees and
            3 % of the baseline.
        budget: units, or a `Budget`, for the whole schedule; default none.
        view: default `sr.view(rig)`; also the arguments of `sr.view` by name, such as {"field": 140}.
        seed: for strategies that draw random numbers.
        free: what may move, `Parameters` or names and groups, such as ("rotation",) or ("extrinsics", "intrinsics");
            default the extrinsics. Intrinsics need several frames of different places; they are solved for at the end,
            and taken only if rows that took no part lie closer under them (`solution.intrinsics` says so). Of more than
            24 frames so many are chosen, and those that ranges name.
        ranges: distances of what single pixels show; they free the length of the baseline, and count beside the rows.
        prior: how well the initial calibration was known before it drifted: "saved", as it was saved with it (also for
            None, if it was), or the prior of an earlier solution, for which pairs that it rests on do not count again;
            "default" (also for None), as a chessboard calibration of this rig; standard deviations by name, or an
            `sr.CalibrationCovariance`; or "exact": its intrinsics are the truth, and all that rows show is a drift.
        boards: those of the calibration itself, of `find_boards` or your own, as the cameras saw them before the rig
            drifted: they take the place of the default prior, and join any other.
        motion: whether the rig's own motion between consecutive pairs is used, which tells depth: True takes the pairs
            as they were taken, one after the other, the rig advancing by a fraction of a baseline or more in between;
            None uses it where pairs know their times, at most half a second apart; False never.
        tolerances: what is asked of a change, and the distances at which it is judged: a `Tolerances`, or some of its
            values by name, such as {"distances": (3, 8), "alpha": 0.001}.
        odometer: how far the rig travelled by wheels or GPS, by the pairs' own clock: with the rig's own motion that
            tells the length of the baseline, which it frees.

    Raises:
        InputError: if images and calibration do not fit, a strategy of the schedule is not installed, the prior makes
            no sense, belongs to another rig, or rests on all these pairs already, or the boards do not fit the
            calibration, or there is nothing that could move.
        StrategyError: if a strategy crashes.
    """
    refuse_tracers("sr.recalibrate", "sr.count, sr.soft_count or sr.row_differences and an optimiser of yours", rig)
    began = time.perf_counter()
    images, reach = pyramid(rig, pairs, view), as_reach(reach)
    schedule, budget, asked = as_schedule(schedule), as_budget(budget), as_matcher(matcher)
    free = with_ranges(as_parameters(free), ranges, odometer)
    free.check(rig)
    limits = as_tolerances(tolerances)
    ranges = resolved_ranges(ranges, [("", images.pairs)])
    check_schedule(schedule, free)
    check_motion(motion, len(images.pairs), prior)
    use = prior_use(with_boards(prior, boards, rig_parameters(rig)), rig, images.pairs)
    numbers = use.numbers
    if free.shared:
        chosen = looked_at([images.pairs[number] for number in numbers], ranges)
        numbers = tuple(numbers[number] for number in chosen)
    if len(numbers) < len(images.pairs):
        images = pyramid(rig, [images.pairs[number] for number in numbers], images.view)
    known = prior_of(use.prior, free, rig, reach, ranges=bool(ranges) or odometer is not None)
    windows = following(images.pairs, numbers, motion, known)
    check_odometer(odometer, images.pairs, windows)
    case = Case(images, asked, reach, free.extrinsics, known, ranges, windows, limits, odometer)
    solution = searched(case, schedule, budget, seed, free)
    wanted = solution.asked and replace(solution.asked, free=free.names)
    chosen = numbers if free.shared or use.dropped else None
    return replace(solution, looked_at=chosen, asked=wanted, prior_use=use, seconds=time.perf_counter() - began)


def searched(case: Case, schedule: Schedule, budget: Budget, seed: int, free: Parameters | None = None) -> Solution:
    """The end of a schedule whose strategies search all that is free in the case, intrinsics too, judged like a repair.

    `recalibrate` gives them the extrinsics alone, and solves for the rest with its own least squares. It looks before
    it searches, as `health` does: what one look finds good stays, and what it is sure to mend is mended, though the
    search may end in doubt; but not by a rig under which rows still lie apart: where they are so far off that they are
    not searched there, a look sees what fits by chance.

    Args:
        case: its matcher may lack `num_disparities`, which is then measured.
        free: what may change in the end, if that is more than what is searched.

    Raises:
        NeedNotMet: if a strategy needs what a score does not offer over this box.
        StrategyError: if a strategy crashes.
    """
    began, asked = time.perf_counter(), Asked(case.matcher, schedule, budget, seed, case.free.names, case.tolerances)
    case, start, cost = started(case, schedule)
    judged = replace(case, free=free or case.free)
    look = looked(judged, schedule.stages[-1])
    if look is not None:
        cost = replace(cost, starts=cost.starts + look.run.cost)
        if look.answer is not None and look.verdict is Verdict.GOOD:
            return solution_of(judged, asked, (look.paid,), cost, began, ended_by(judged, look.answer, case.rig))
    widest, stages = _run_schedule(case, schedule, asked.matcher, start, budget, began, seed)
    judged = replace(widest, free=judged.free)
    found = solution_of(judged, asked, stages, cost, began)
    if found.accepted or found.reason is Reason.OUT_OF_BUDGET or look is None or look.answer is None:
        return found
    if look.verdict is not Verdict.REPAIR or not look.answer.decision.explains:
        return found
    return solution_of(judged, asked, (*stages, look.paid), cost, began, ended_by(judged, look.answer, case.rig))


def started(case: Case, schedule: Schedule) -> tuple[Case, StereoRig, Cost]:
    """What comes before the first stage: the case with a disparity range, where the stage begins, and what it took."""
    asked, offset, of_survey = case.matcher, np.zeros(6), 0.0
    if schedule.survey or asked.num_disparities is None:
        radians = float(np.radians(case.reach.degrees))
        seen = survey(case.images, case.rig.extrinsics, radians)
        case, of_survey = case.with_matcher(seen.with_range(asked, radians)), seen.cost
        offset = seen.offset if schedule.survey else offset
    # The images belong together, so most repairs come to these.
    later = [case.scale_of(stage) for stage in schedule.stages if stage.score is ScoreKind.EPIPOLAR]
    for scale in dict.fromkeys(later):
        host.compile_in_background(case.images.sample(scale))
    start, of_starts = better_start(case, schedule.stages[0], offset)
    return case, start, Cost(survey=of_survey, starts=of_starts)


def _run_schedule(
    case: Case,
    schedule: Schedule,
    asked: AbstractMatcher,
    start: StereoRig,
    budget: Budget,
    began: float,
    seed: int,
) -> tuple[Case, tuple[StageRun, ...]]:
    """All stages that the budget allows; the case comes back with the widest disparity range that was measured."""
    widest, best, stages = case, start, []
    for stage in schedule.stages:
        left = remaining(budget, sum(done.cost for done in stages), began)
        if left is None:
            break
        done = run_stage(case, stage, best, left, seed)
        best = done.ended
        if len(schedule.stages) > 1 and asked.num_disparities is None:
            yaw_left = float(_YAW_LEFT if stage.score is ScoreKind.EPIPOLAR else np.radians(case.reach.degrees))
            seen = survey(case.images, done.best, yaw_left, aligned=True)
            done = replace(done, survey_cost=seen.cost)
            case = case.with_matcher(seen.with_range(asked, yaw_left))
            widest = max(widest, case, key=lambda c: c.matcher.num_disparities or 0)
        stages.append(done)
    return widest, tuple(stages)


def solution_of(
    case: Case, asked: Asked, stages: tuple[StageRun, ...], cost: Cost, began: float, ending: Ending | None = None
) -> Solution:
    """The end of the stages of a schedule, judged.

    Args:
        asked: what was asked for, the schedule included.
        cost: of what came before them.
        began: when the clock was started.
        ending: of a look, where that decided; default that of the stages.
    """
    runs = [run for stage in stages for run in stage.runs]
    cut = ending is None and (len(stages) < len(asked.schedule.stages) or any(stage.cut for stage in stages))
    status, message = (runs[-1].status, runs[-1].message) if runs else (Status.NO_SIGNAL, Status.NO_SIGNAL.value)
    if ending is not None:
        status, message = Status.CONVERGED, "one look at the images was enough"
    elif cut:
        status, message = Status.BUDGET, Status.BUDGET.value
    if ending is None:
        ending = _ended(case, stages, cut=cut, signal=status is not Status.NO_SIGNAL)
    reason = ending.reason
    if reason is Reason.TOO_LITTLE_TEXTURE and any(image_quality(pair).enough for pair in case.images.pairs):
        reason = Reason.NO_MATCHES
    frames = len(case.images.pairs)
    kept = np.isin(np.arange(frames), ending.without, invert=True)
    pixels = case.images.at(1.0).pixels * int(kept.sum()) // frames  # all of one size
    before, after = (Score(int(found.sum()), pixels) for found in ending.tiles[:, kept])
    apart = tuple(case.images.pairs[f].name for f in ending.apart)
    matched = NO_BEAMS if ending.estimate is None else ending.estimate.beams
    return Solution(
        rig=ending.candidate if reason.accepted else case.rig,
        candidate=ending.candidate,
        initial=case.rig,
        accepted=reason.accepted,
        reason=reason,
        status=status,
        message=message,
        view=case.images.view,
        matcher=case.matcher,
        reach=case.reach,
        free=ending.free or case.free,
        cost=Cost(
            survey=cost.survey + sum(stage.survey_cost for stage in stages),
            starts=cost.starts,
            search=sum(stage.search_cost for stage in stages),
            correspondences=sum(stage.matching_cost for stage in stages),
            judging=sum(stage.judging_cost for stage in stages) + 2 * case.images.at(1.0).cost,
        ),
        score_before=before,
        score_after=after,
        row_errors=ending.rows,
        uncertainty=ending.uncertainty,
        misfit=ending.misfit,
        intrinsics=ending.intrinsics,
        kept=tuple(np.flatnonzero(kept).tolist()),
        left_out=() if reason is Reason.FRAMES_DISAGREE else apart,
        disagreeing=apart if reason is Reason.FRAMES_DISAGREE else (),
        stages=stages,
        seconds=time.perf_counter() - began,
        asked=asked,
        estimate=ending.estimate,
        beams=matched,
        ranges=ranges_seen(len(case.ranges), matched, case.rig, ending.candidate, reason),
        decision=ending.decision,
    )


def _ended(case: Case, stages: tuple[StageRun, ...], *, cut: bool, signal: bool) -> Ending:
    """How the stages ended."""
    near = stages[-1].ended if stages else case.rig
    found = next((stage.found for stage in reversed(stages) if stage.found is not None), None)
    if not cut and found is not None and found.found >= FEWEST:
        return ended_by(case, answered(case, found, near, stages[-1].scale), near)
    tiles = counts(case, near)
    if cut:
        return Ending(near, Reason.OUT_OF_BUDGET, tiles)  # the count alone hardly sees a wrong yaw
    if found is not None:
        return Ending(near, Reason.TOO_LITTLE_TEXTURE, tiles)
    before, after = tiles.sum(axis=(1, 2)).tolist()
    return Ending(near, verdict_on_count(before, after, signal=signal), tiles)
