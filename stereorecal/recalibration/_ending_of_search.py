"""The ending of a search: its candidate, and the verdict on it by the estimate, or, where there are no rows, by the
count."""

from dataclasses import replace

from stereorecal.recalibration._acceptance import Reason, verdict_on_count
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._ending import Ending, counts
from stereorecal.recalibration._estimate_and_decide import ended_by, estimate_and_decide
from stereorecal.recalibration._schedule import Schedule
from stereorecal.recalibration._stages import FEWEST, StageRun, last_matched
from stereorecal.recalibration._vertical_offsets import with_vertical_offsets
from stereorecal.strategies import Status


def ending_of(case: Case, schedule: Schedule, stages: tuple[StageRun, ...]) -> Ending:
    """The candidate that the stages of a schedule come to, judged.

    Args:
        case: with all that may change free.
        stages: that were run: fewer than the schedule has where a budget ended.
    """
    runs = [run for stage in stages for run in stage.runs]
    status, message = (runs[-1].status, runs[-1].message) if runs else (Status.NO_SIGNAL, Status.NO_SIGNAL.value)
    cut = len(stages) < len(schedule.stages) or any(stage.cut for stage in stages)
    if cut:
        status, message = Status.BUDGET, Status.BUDGET.value
    ending = _ended(case, stages, cut=cut, signal=status is not Status.NO_SIGNAL)
    return replace(ending, status=status, message=message)


def _ended(case: Case, stages: tuple[StageRun, ...], *, cut: bool, signal: bool) -> Ending:
    end_rig = stages[-1].ended if stages else case.rig
    run = last_matched(stages)
    if not cut and run is not None and run.found is not None and run.found.found >= FEWEST:
        with_offsets = with_vertical_offsets(case, run, end_rig)
        ending = ended_by(case, estimate_and_decide(case, with_offsets, end_rig, corners=True))
        return replace(ending, judging_cost=with_offsets.matching_cost - run.matching_cost)
    tiles = counts(case, end_rig)
    if cut:
        return Ending(end_rig, Reason.OUT_OF_BUDGET, tiles)  # the count alone hardly sees a wrong yaw
    if run is not None:
        return Ending(end_rig, Reason.TOO_LITTLE_TEXTURE, tiles)
    before, after = tiles.sum(axis=(1, 2)).tolist()
    return Ending(end_rig, verdict_on_count(before, after, signal=signal), tiles)
