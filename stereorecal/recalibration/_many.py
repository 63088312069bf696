"""Repairing many recordings: each in a task of its own, and then together what they share."""

import enum
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from traceback import format_exception
from typing import Any, Unpack

from stereorecal._errors import InputError, PluginError
from stereorecal._run_all import Progress, run_all
from stereorecal.geometry import checked_rig, same_cameras
from stereorecal.objectives import Parameters
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import resolved_ranges
from stereorecal.recalibration._recalibrate import prepared, recalibrate_case, what_may_change
from stereorecal.recalibration._schedule import Schedule, check_schedule
from stereorecal.recalibration._settings import RepairOptions, Settings, as_settings
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._together import RepairedRecording, solve_jointly
from stereorecal.recordings import Range, Scene


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
        """Plain data for JSON; what is missing is None."""
        found = {} if self.solution is None else self.solution.to_dict()
        return {"scene": self.name, "error": self.error, "fault": self.fault and self.fault.name.lower(), **found}


def recalibrate_many(
    scenes: Scene | Sequence[Scene],
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
    finished: Callable[[int, Repair], None] | None = None,
    **options: Unpack[RepairOptions],
) -> tuple[Repair, ...]:
    """Repair the calibration of many recordings; the answers come in the order of the recordings.

    Each recording has extrinsics of its own, as a rig that drifts between missions; where it did not drift, give all
    pairs as one recording. Recordings of one rig share what is found of its intrinsics: once each is repaired, all are
    estimated together (`Solution.intrinsics` says what came of it), but for those whose images show other intrinsics.
    If nothing is said of what is free, those of different calibrations are repaired apart. Ranges free the length of
    the baseline, which all share. Where the joint solution fails, the repairs stand, each with an error that says so.

    A recording that cannot be repaired is an answer with an error, never an exception. Ctrl-C passes; whoever takes
    each answer with `finished` has those that are there by then.

    Args:
        scenes: each with a rig and its pairs. Pairs that came from files travel to the workers as paths.
        executor: any `concurrent.futures.Executor`; default one recording after the other in this process.
        progress: called with (finished, total) after each recording.
        finished: called with the number of a recording and its repair as soon as that is there, in the order in which
            they finish; what recordings share is as it was by then.
        options: as `recalibrate` has them, for every recording; `RepairOptions` describes them.

    Raises:
        InputError: if there is no recording, a strategy of the default schedule is not installed, or intrinsics are
            free and the recordings are of different rigs.
        StrategyError: if one of those is broken.
        TypeError: if there is no option of a name.
    """
    settings, scenes = as_settings(options), (scenes,) if isinstance(scenes, Scene) else tuple(scenes)
    if not scenes:
        raise InputError("there is nothing to repair; give at least one recording.")
    scenes = tuple(one if one.rig is None else replace(one, rig=one.rig.side_by_side()) for one in scenes)
    free = _shared_by(scenes, settings)
    _check_sharing(scenes, free, settings.schedule)
    ranges = resolved_ranges(settings.ranges, [(scene.name, scene.pairs) for scene in scenes])
    tasks = [_case_or_fault(scene, {**options, "ranges": _of_recording(scene, ranges)}) for scene in scenes]
    done: dict[int, Repair] = {}
    for index, found in run_all(_repaired_or_fault, tasks, executor):
        done[index] = found if isinstance(found, Repair) else _failed(scenes[index].name, found)
        if finished is not None:
            finished(index, done[index])
        if progress is not None:
            progress(len(done), len(scenes))
    repairs = tuple(done[index] for index in range(len(scenes)))
    if len(repairs) == 1:
        return repairs
    return _repaired_together(tasks, repairs, free, executor)


def _shared_by(scenes: Sequence[Scene], settings: Settings) -> Parameters:
    """What is free; where that is everything, by name for several recordings of one rig, which share it."""
    rigs = [scene.rig for scene in scenes if scene.rig is not None]
    one = all(same_cameras(rig, rigs[0]) for rig in rigs)
    return what_may_change(rigs[0], settings) if len(rigs) > 1 and one else settings.free


def _check_sharing(scenes: Sequence[Scene], free: Parameters, schedule: Schedule) -> None:
    """Refuse recordings that cannot share what is free, before any work is done."""
    rigs = [scene.rig for scene in scenes if scene.rig is not None]
    if free.shared and rigs:
        free.check(rigs[0])
        for scene in scenes:
            if scene.rig is not None and not same_cameras(scene.rig, rigs[0]):
                raise InputError(
                    f"{scene.name} has other intrinsics than {scenes[0].name}; recordings of one rig can share them: "
                    "repair those of different rigs apart."
                )
    check_schedule(schedule, free)


def _of_recording(scene: Scene, ranges: Sequence[Range]) -> tuple[Range, ...]:
    """The ranges of its pairs, by their numbers: however a pair travels, or is turned."""
    numbers = {id(pair): number for number, pair in enumerate(scene.pairs)}
    return tuple(replace(one, pair=numbers[id(one.pair)]) for one in ranges if id(one.pair) in numbers)


def _case_or_fault(scene: Scene, options: Mapping[str, Any]) -> tuple[str, Case] | Repair:
    """The name and the case of a recording: only what is looked at travels to a worker."""
    try:
        if scene.rig is None:
            raise InputError("the scene has no calibration; give one to start from.")
        return scene.name, prepared(checked_rig(scene.rig), scene.pairs, as_settings(options))
    except Exception as error:
        return _failed(scene.name, error)


def _repaired_or_fault(task: tuple[str, Case] | Repair) -> Repair:
    """The repair of one recording, in a worker: whatever goes wrong comes back as text, which always pickles."""
    if isinstance(task, Repair):
        return task
    name, case = task
    try:
        return Repair(name, recalibrate_case(case.anew))
    except Exception as error:
        return _failed(name, error)


def _repaired_together(
    tasks: Sequence[tuple[str, Case] | Repair], repairs: Sequence[Repair], free: Parameters, executor: Executor | None
) -> tuple[Repair, ...]:
    """Finished repairs with what they share estimated together; those that failed stay as they are.

    Where the joint solution fails, the repairs stand, each with an error that says so.
    """

    def each(function: Callable[..., Any], *arguments: Sequence[Any]) -> list[Any]:
        calls = [(function, *several) for several in zip(*arguments, strict=True)]
        done = dict(run_all(_called, calls, executor))
        for found in done.values():
            if isinstance(found, BaseException):
                raise found
        return [done[index] for index in range(len(calls))]

    recordings = {
        index: RepairedRecording(replace(task[1], matcher=repair.solution.matcher), repair.solution)
        for index, (task, repair) in enumerate(zip(tasks, repairs, strict=True))
        if repair.solution is not None and not isinstance(task, Repair)
    }
    if not recordings or not free.shared:
        return tuple(repairs)
    try:
        found = solve_jointly(list(recordings.values()), free, each)
    except Exception as error:
        failed = _failed("", error)
        message = f"the joint solution failed; the separate repairs are used: {failed.error}"
        return tuple(
            replace(r, error=r.error or message, fault=r.fault or failed.fault, traceback=failed.traceback)
            for r in repairs
        )
    joint = dict(zip(recordings, found, strict=True))
    return tuple(replace(one, solution=joint.get(index, one.solution)) for index, one in enumerate(repairs))


def _called(call: tuple[Any, ...]) -> Any:
    function, *arguments = call
    return function(*arguments)


def _failed(name: str, error: BaseException) -> Repair:
    if isinstance(error, InputError):
        return Repair(name, error=str(error), fault=Fault.INPUT)
    hint = "see where it comes from with --traceback (or in Repair.traceback), and please report it"
    message = str(error) if isinstance(error, PluginError) else f"internal error ({error!r}); {hint}."
    return Repair(name, error=message, fault=Fault.INSIDE, traceback="".join(format_exception(error)))
