"""One trial: a method meets a case, and a judge says what came of it."""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.strategies import NeedNotMet
from stereorecal_field.judges import AbstractRecipe, Case, Judgement, case_of
from stereorecal_field.table._memory import PeakMemory
from stereorecal_field.table._methods import ACCEPTED, AbstractMethod, Answer

FAILED, SKIPPED = "failed", "skipped"


@dataclass(frozen=True)
class FieldTask:
    """All that a worker needs for one trial; small, since the worker makes the case."""

    recipe: AbstractRecipe
    method: AbstractMethod
    matcher: AbstractMatcher
    reach: Reach
    seed: int

    @property
    def key(self) -> str:
        """What tells it from all others of a table."""
        return f"{self.recipe.key} | {self.method.name}"


@dataclass(frozen=True)
class FieldTrial:
    """One row; what a trial does not have is None.

    Attributes:
        key: what tells it from all others of a table.
        judge, scene, method: of the trial.
        draw: of the drift, or the moment of a walk; None: the calibration as it is stored.
        status: "accepted" (the calibration is replaced), "good" (the method says that nothing is wrong), "refused",
            "skipped" (what the method needs is not there) or "failed".
        message: in the method's own words.
        prior: what it was told of the intrinsics.
        frames: pairs that it was given.
        row_error_px: of the "start" and of the calibration in use at the "final", by the judge.
        depth_error_percent: likewise, by distance in baselines.
        rotation_error_deg: likewise, of pitch, yaw and roll; None where the true rig is not known.
        stated_percent: 95 % interval of the error of depth at 30 baselines that the method states of that calibration.
        covered: whether the judge's error lies in it.
        harmful: whether it was accepted and is worse than the start.
        seconds: wall time, with compilation where a process meets a program for the first time.
        memory_mib: how much memory it took at most; None where threads share it, or it is not known.
    """

    key: str
    judge: str
    scene: str
    draw: int | None
    method: str
    status: str
    message: str
    prior: str | None = None
    frames: int | None = None
    row_error_px: dict[str, float] | None = None
    depth_error_percent: dict[str, dict[str, float]] | None = None
    rotation_error_deg: dict[str, dict[str, float]] | None = None
    stated_percent: list[float] | None = None
    covered: bool | None = None
    harmful: bool | None = None
    seconds: float | None = None
    memory_mib: float | None = None


def run_field_trial(task: FieldTask) -> FieldTrial:
    """Run one trial. Whatever goes wrong becomes a row, never an exception."""
    try:
        case = case_of(task.recipe)
        with PeakMemory() as memory:
            began = time.perf_counter()
            answer = task.method.solve(case, task.matcher, task.reach, task.seed)
            seconds = time.perf_counter() - began
        return _judged_answer(task, case, answer, seconds, memory.mebibytes)
    except NeedNotMet as error:
        return _without(task, SKIPPED, str(error))
    except Exception as error:
        return failed(task, error)


def failed(task: FieldTask, error: BaseException) -> FieldTrial:
    """The row of a task whose worker raised."""
    return _without(task, FAILED, str(error) or repr(error))


def _judged_answer(task: FieldTask, case: Case, answer: Answer, seconds: float, memory: float | None) -> FieldTrial:
    before = case.judge(case.start)
    after = case.judge(answer.rig) if answer.status == ACCEPTED else before
    both = {"start": before, "final": after}
    covered = None
    if answer.stated is not None and after.depth_error_percent is not None:
        low, high = answer.stated
        covered = bool(low <= after.depth_error_percent[30] <= high)
    return FieldTrial(
        **_key(task),
        status=answer.status,
        message=answer.message,
        prior=case.prior,
        frames=len(case.pairs),
        row_error_px={when: float(one.row_error_px) for when, one in both.items()},
        depth_error_percent=_depths(both),
        rotation_error_deg=_angles(both),
        stated_percent=None if answer.stated is None else list(answer.stated),
        covered=covered,
        harmful=answer.status == ACCEPTED and after.worse_than(before),
        seconds=seconds,
        memory_mib=memory,
    )


def _angles(both: dict[str, Judgement]) -> dict[str, dict[str, float]] | None:
    known = {when: one.rotation_error_deg for when, one in both.items() if one.rotation_error_deg is not None}
    return known if len(known) == len(both) else None


def _depths(both: dict[str, Judgement]) -> dict[str, dict[str, float]] | None:
    known = {when: one.depth_error_percent for when, one in both.items() if one.depth_error_percent is not None}
    if len(known) < len(both):
        return None
    return {when: {str(at): float(error) for at, error in errors.items()} for when, errors in known.items()}


def _key(task: FieldTask) -> dict[str, Any]:
    recipe, method = task.recipe, task.method.name
    return {"key": task.key, "judge": recipe.judge, "scene": recipe.scene, "draw": recipe.draw, "method": method}


def _without(task: FieldTask, status: str, message: str) -> FieldTrial:
    return FieldTrial(**_key(task), status=status, message=message)


def as_trial(row: dict[str, Any]) -> FieldTrial:
    """The trial that a JSON object says; what JSON has no number for (None) is infinite depth, or unknown rows.

    Raises:
        TypeError, ValueError, KeyError: if it is none.
    """
    trial = FieldTrial(**row)
    rows, depths = trial.row_error_px, trial.depth_error_percent
    return FieldTrial(
        **{
            **row,
            "row_error_px": rows and {when: _number_or(value, np.nan) for when, value in rows.items()},
            "depth_error_percent": depths
            and {when: {at: _number_or(value, np.inf) for at, value in of.items()} for when, of in depths.items()},
        }
    )


def _number_or(value: Any, missing: float) -> float:
    return missing if value is None else float(value)
