"""Repairing many recordings, one task each."""

import enum
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any

from stereorecal._errors import InputError, StrategyError
from stereorecal._run_all import Progress, run_all
from stereorecal.geometry import View
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration._as_dict import solution_as_dict
from stereorecal.recalibration._recalibrate import recalibrate
from stereorecal.recalibration._schedule import Schedule
from stereorecal.recalibration._solution import Solution
from stereorecal.recordings import Scene
from stereorecal.strategies import Budget


class Fault(enum.Enum):
    """Why a recording has no solution; the value is the message."""

    INPUT = "the recording or an option cannot be used"
    INSIDE = "a strategy, a worker or the library itself failed"
    INTERRUPTED = "interrupted before it was finished"


@dataclass(frozen=True, eq=False)
class Repair:
    """What became of one recording: a solution, or an error.

    Attributes:
        name: of the recording.
        solution: None if there is none.
        error: None, or one sentence that says why there is no solution.
        fault: whose fault that is; None with a solution.
    """

    name: str
    solution: Solution | None = None
    error: str | None = None
    fault: Fault | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables; what is missing is None."""
        found = {} if self.solution is None else solution_as_dict(self.solution)
        return {"scene": self.name, "error": self.error, "fault": self.fault and self.fault.name.lower(), **found}


def recalibrate_many(
    scenes: Sequence[Scene],
    *,
    matcher: AbstractMatcher | None = None,
    schedule: Schedule | None = None,
    reach: Reach | None = None,
    budget: Budget | None = None,
    view: View | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Repair, ...]:
    """Repair the extrinsics of many recordings, each on its own; the answers come in the order of the recordings.

    A recording that cannot be repaired is an answer with an error, never an exception. Ctrl-C ends it: what is finished
    is returned, the rest has `Fault.INTERRUPTED`.

    Args:
        scenes: each with a rig and its pairs. Pairs that came from files travel to the workers as paths.
        matcher, schedule, reach, view, seed: as `recalibrate` has them, for every recording.
        budget: of each recording.
        executor: any `concurrent.futures.Executor`; default one recording after the other in this process.
        progress: called with (finished, total) after each recording.

    Raises:
        InputError: if there is no recording, or a strategy of the default schedule is not installed.
        StrategyError: if one of those is broken.
    """
    if not scenes:
        raise InputError("there is nothing to repair; give at least one recording.")
    repair = partial(
        _repair,
        matcher=matcher,
        schedule=schedule or Schedule.default(),
        reach=reach,
        budget=budget,
        view=view,
        seed=seed,
    )
    finished: dict[int, Repair] = {}
    try:
        for index, found in run_all(repair, scenes, executor):
            finished[index] = found if isinstance(found, Repair) else _failed(scenes[index].name, found)
            if progress is not None:
                progress(len(finished), len(scenes))
    except KeyboardInterrupt:
        pass
    missing = Fault.INTERRUPTED
    return tuple(
        finished.get(index) or Repair(scene.name, error=missing.value, fault=missing)
        for index, scene in enumerate(scenes)
    )


def _repair(scene: Scene, **options: Any) -> Repair:
    """Repair one recording, in a worker: whatever goes wrong comes back as text, which always pickles."""
    try:
        if scene.rig is None:
            raise InputError("the scene has no calibration; give one to start from.")
        return Repair(scene.name, recalibrate(scene.rig, scene.pairs, **options))
    except Exception as error:
        return _failed(scene.name, error)


def _failed(name: str, error: BaseException) -> Repair:
    if isinstance(error, InputError):
        return Repair(name, error=str(error), fault=Fault.INPUT)
    message = str(error) if isinstance(error, StrategyError) else f"internal error, please report it: {error!r}"
    return Repair(name, error=message, fault=Fault.INSIDE)
