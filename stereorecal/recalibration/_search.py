"""The search of a repair: a survey that finds a start and the disparity range, then the stages of a schedule; at once,
or in slices, for those who cannot wait for all of it; and the solution that its end, or a look at the images, comes
to."""

import time
from dataclasses import dataclass, replace

import numpy as np

from stereorecal.decision import Reason, Seen, reason_of
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._assessment import assessed, counts, solution_of
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._mismatch import mismatch_of
from stereorecal.recalibration._schedule import ScoreKind
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import Cost, StageRun, last_matched, remaining, run_stage, started
from stereorecal.scoring.host import survey
from stereorecal.strategies import Budget, Status

_YAW_ERROR_AFTER_EPIPOLAR = np.radians(0.25)  # at most, where yaw is observed
_SEED = 0  # of strategies that draw random numbers, in slices


def solution_of_search(
    case: Case, stages: tuple[StageRun, ...], cost: Cost, began: float, *, cut: bool = False
) -> Solution:
    """The solution that the stages of a schedule come to, judged by matches, or, where there are none, by the count.

    Args:
        stages: that were run.
        cost: of what came before the stages.
        began: when the clock was started.
        cut: whether the budget ended before all stages were run.
    """
    status, message = _ending(stages)
    if cut := cut or any(stage.cut for stage in stages):
        status, message = Status.BUDGET, Status.BUDGET.value
    if not cut and (found := assessed(case, stages, cost, began)[0]) is not None:
        return replace(found, status=status, message=message)
    run = last_matched(stages)
    end_rig = stages[-1].ended if stages else case.rig
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
    found = solution_of(case, stages, end_rig, reason, tiles, cost, began, mismatch=mismatch)
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


def run_schedule(case: Case, start: StereoRig, began: float) -> tuple[Case, tuple[StageRun, ...]]:
    """All stages that the budget allows; the case comes back with the widest disparity range that was measured; the
    clock of the budget was started when it `began`."""
    settings = case.settings
    schedule, measured = settings.schedule, settings.matcher.num_disparities is None
    widest, rig, stages = case, start, []
    for stage in schedule.stages:
        budget_left = remaining(settings.budget, sum(done.cost.budgeted for done in stages), began)
        if budget_left is None:
            break
        done = run_stage(case, stage, rig, budget_left, settings.seed)
        rig = done.ended
        if len(schedule.stages) > 1 and measured:
            epipolar = stage.score is ScoreKind.EPIPOLAR
            yaw_error = float(_YAW_ERROR_AFTER_EPIPOLAR if epipolar else np.radians(case.settings.reach.degrees))
            surveyed = survey(case.images, np.asarray(rig.extrinsics), yaw_error, aligned=True)
            done = replace(done, cost=done.cost + Cost(survey=surveyed.cost))
            case = replace(case, matcher=surveyed.with_range(settings.matcher, yaw_error))
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
    began = time.perf_counter()
    if at.done == 0:
        return Progress(started(case)[1], 1)
    rounds = [replace(stage, rounds=1) for stage in case.settings.schedule.stages for _ in range(stage.rounds)]
    done = run_stage(case, rounds[at.done - 1], at.rig, Budget(), _SEED)
    if at.done < len(rounds):
        return Progress(done.ended, at.done + 1)
    return solution_of_search(case, (done,), Cost(), began)
