"""Repairing many recordings, one task each."""

import enum
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from traceback import format_exception
from typing import Any

from stereorecal._errors import InputError, StrategyError
from stereorecal._run_all import Progress, run_all
from stereorecal.geometry import View
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.objectives import Reach
from stereorecal.recalibration._as_dict import solution_as_dict
from stereorecal.recalibration._recalibrate import recalibrate
from stereorecal.recalibration._schedule import Schedule, as_schedule
from stereorecal.recalibration._solution import Solution
from stereorecal.recordings import Scene
from stereorecal.strategies import Budget, as_budget


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
        traceback: of a failure inside, as text; else None.
    """

    name: str
    solution: Solution | None = None
    error: str | None = None
    fault: Fault | None = None
    traceback: str | None = field(default=None, repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables; what is missing is None."""
        found = {} if self.solution is None else solution_as_dict(self.solution)
        return {"scene": self.name, "error": self.error, "fault": self.fault and self.fault.name.lower(), **found}


def recalibrate_many(
    scenes: Scene | Sequence[Scene],
    *,
    matcher: AbstractMatcher | str | None = None,
    schedule: Schedule | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    budget: Budget | float | None = None,
    view: View | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Repair, ...]:
    """Repair the extrinsics of many recordings, each on its own; the answers come in the order of the recordings.

    A recording that cannot be repaired is an answer with an error, never an exception. Ctrl-C passes; to keep what is
    finished by then, take the answers one by one from `repairs_as_finished`.

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
    scenes = _as_scenes(scenes)
    options = {"schedule": schedule, "reach": reach, "budget": budget, "view": view, "seed": seed}
    finished: dict[int, Repair] = {}
    for index, repair in repairs_as_finished(scenes, matcher=matcher, executor=executor, **options):
        finished[index] = repair
        if progress is not None:
            progress(len(finished), len(scenes))
    return tuple(finished[index] for index in range(len(scenes)))


def repairs_as_finished(
    scenes: Scene | Sequence[Scene],
    *,
    matcher: AbstractMatcher | str | None = None,
    schedule: Schedule | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    budget: Budget | float | None = None,
    view: View | None = None,
    seed: int = 0,
    executor: Executor | None = None,
) -> Iterator[tuple[int, Repair]]:
    """`recalibrate_many` for those who show or save each answer as soon as it is there: the index of a recording and
    its repair, in the order in which they finish. Arguments and errors as there; errors are raised at once."""
    scenes = _as_scenes(scenes)
    if not scenes:
        raise InputError("there is nothing to repair; give at least one recording.")
    repair = partial(
        _repair,
        matcher=as_matcher(matcher),
        schedule=as_schedule(schedule),
        reach=reach,
        budget=as_budget(budget),
        view=view,
        seed=seed,
    )

    def repairs() -> Iterator[tuple[int, Repair]]:
        for index, found in run_all(repair, scenes, executor):
            yield index, found if isinstance(found, Repair) else _failed(scenes[index].name, found)

    return repairs()


def _as_scenes(scenes: Scene | Sequence[Scene]) -> tuple[Scene, ...]:
    return (scenes,) if isinstance(scenes, Scene) else tuple(scenes)


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
    hint = "see where it comes from with --traceback (or in Repair.traceback), and please report it"
    message = str(error) if isinstance(error, StrategyError) else f"internal error ({error!r}); {hint}."
    return Repair(name, error=message, fault=Fault.INSIDE, traceback="".join(format_exception(error)))
