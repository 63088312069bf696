"""A repair cut into slices, for those who cannot wait for all of it at once."""

import time
from dataclasses import dataclass, replace

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._schedule import Schedule, ScoreKind, Stage
from stereorecal.recalibration._search_start import started
from stereorecal.recalibration._settings import as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._solution_of import solution_of_search
from stereorecal.recalibration._stages import run_stage
from stereorecal.strategies import Budget

_SEED = 0  # of strategies that draw random numbers


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a repair is.

    Attributes:
        rig: where the next slice begins: the best so far.
        done: slices so far.
    """

    rig: StereoRig
    done: int = 0


def next_slice(case: Case, schedule: Schedule, at: Progress) -> Progress | Solution:
    """One slice more: first the survey, then a stage on the count, or one round of a stage on the rows, each begun
    where the one before it ended; the last one is judged with it.

    Args:
        case: with a disparity range.
        schedule: whose last stage has rows.
    """
    began = time.perf_counter()
    if at.done == 0:
        return Progress(started(case, schedule)[1], 1)
    stages = _rounds(schedule)
    stage = stages[at.done - 1]
    done = run_stage(case, stage, at.rig, Budget(), _SEED)
    if at.done < len(stages):
        return Progress(done.ended, at.done + 1)
    last = replace(schedule, stages=(stage,))
    settings = as_settings({"matcher": case.matcher, "schedule": last, "reach": case.reach})
    settings = replace(settings, free=case.free, tolerances=case.tolerances)
    return solution_of_search(case, settings, (done,), Cost(), began)


def _rounds(schedule: Schedule) -> tuple[Stage, ...]:
    """The stages, those on the rows cut into their rounds."""
    return tuple(
        replace(stage, rounds=1)
        for stage in schedule.stages
        for _ in range(stage.rounds if stage.score is ScoreKind.EPIPOLAR else 1)
    )
