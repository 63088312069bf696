"""Repairing many recordings: each in a task of its own, and then together what they share."""

import enum
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from traceback import format_exception
from typing import Any, Unpack

from stereorecal._errors import InputError, PluginError
from stereorecal._run_all import Progress, run_all
from stereorecal.geometry import same_cameras
from stereorecal.objectives import Parameters
from stereorecal.recalibration._case import selected_frames
from stereorecal.recalibration._match_ranges import resolved_ranges
from stereorecal.recalibration._recalibrate import recalibrate, what_may_change
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
    scenes, ranges = sharing(scenes, free, settings.ranges, settings.schedule)
    tasks = [(scene, {**options, "ranges": _of_recording(scene, ranges)}) for scene in scenes]
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
    return _repaired_together(scenes, repairs, free, ranges=ranges, executor=executor)


def _shared_by(scenes: Sequence[Scene], settings: Settings) -> Parameters:
    """What is free; where that is everything, by name for several recordings of one rig, which share it."""
    rigs = [scene.rig for scene in scenes if scene.rig is not None]
    one = all(same_cameras(rig, rigs[0]) for rig in rigs)
    return what_may_change(rigs[0], settings) if len(rigs) > 1 and one else settings.free


def sharing(
    scenes: Sequence[Scene], free: Parameters, ranges: Sequence[Range], schedule: Schedule
) -> tuple[tuple[Scene, ...], tuple[Range, ...]]:
    """The recordings with the frames that are looked at, and the ranges with the pairs that they mean, checked before
    any work is done.

    Raises:
        InputError: if they cannot share what is free, or a range belongs to no pair of them.
    """
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
    ranges = resolved_ranges(ranges, [(scene.name, scene.pairs) for scene in scenes])
    if not free.shared:
        return tuple(scenes), ranges
    return tuple(
        replace(scene, pairs=tuple(scene.pairs[number] for number in selected_frames(scene.pairs, ranges)))
        for scene in scenes
    ), ranges


def _repaired_together(
    scenes: Sequence[Scene],
    repairs: Sequence[Repair],
    free: Parameters,
    *,
    ranges: Sequence[Range],
    executor: Executor | None,
) -> tuple[Repair, ...]:
    """Finished repairs with what they share estimated together; those that failed stay as they are.

    Where the joint solution fails, the repairs stand, each with an error that says so.
    """
    solved = [(index, repair.solution) for index, repair in enumerate(repairs) if repair.solution is not None]
    if not solved or not free.shared:
        return tuple(repairs)

    def each(function: Callable[[Any], Any], tasks: Sequence[Any]) -> Sequence[Any]:
        done = dict(run_all(function, tasks, executor))
        for found in done.values():
            if isinstance(found, BaseException):
                raise found
        return [done[index] for index in range(len(tasks))]

    recordings = []
    for index, solution in solved:
        pairs, some = scenes[index].pairs, solution.selected
        pairs = tuple(pairs if some is None else (pairs[number] for number in some))
        of_these = tuple(one for one in ranges if any(one.pair is pair for pair in pairs))
        recordings.append(RepairedRecording(pairs, solution, of_these))
    try:
        found = solve_jointly(recordings, free, each)
    except Exception as error:
        failed = _failed("", error)
        message = f"the joint solution failed; the separate repairs are used: {failed.error}"
        return tuple(
            replace(r, error=r.error or message, fault=r.fault or failed.fault, traceback=failed.traceback)
            for r in repairs
        )
    answers = list(repairs)
    for (index, _), solution in zip(solved, found, strict=True):
        answers[index] = replace(answers[index], solution=solution)
    return tuple(answers)


def _of_recording(scene: Scene, ranges: Sequence[Range]) -> tuple[Range, ...]:
    """The ranges of its pairs, by their numbers: however a pair travels."""
    numbers = {id(pair): number for number, pair in enumerate(scene.pairs)}
    return tuple(replace(one, pair=numbers[id(one.pair)]) for one in ranges if id(one.pair) in numbers)


def _repaired_or_fault(task: tuple[Scene, Mapping[str, Any]]) -> Repair:
    """The repair of one recording with its options, in a worker: whatever goes wrong comes back as text, which always
    pickles."""
    scene, options = task
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
    message = str(error) if isinstance(error, PluginError) else f"internal error ({error!r}); {hint}."
    return Repair(name, error=message, fault=Fault.INSIDE, traceback="".join(format_exception(error)))
