"""`reproduce`: run the experiments; finished tasks are saved."""

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import jax
import numpy as np

from stereorecal import InputError
from stereorecal.cli import Progress, hold, run_all, versions
from stereorecal.geometry import StereoRig
from stereorecal.io import json_data
from stereorecal.matching import SAD, AbstractMatcher, as_matcher, name_of, origin_of as origin_of_matcher
from stereorecal.objectives import Reach
from stereorecal.recordings import Log, names_of
from stereorecal.strategies import origin_of
from stereorecal_paper import _summaries as summaries
from stereorecal_paper._experiment_tasks import Task
from stereorecal_paper._experiments import EXPERIMENTS, Extent, Setting, methods
from stereorecal_paper._logged_pair import Row
from stereorecal_paper._published import TABLE_1, TABLE_2
from stereorecal_paper._row_store import Store

SCHEMA = "stereorecal.reproduce/1"


@dataclass(frozen=True)
class Reproduction:
    """The results of the experiments.

    Attributes:
        settings: the arguments of the run.
        versions: of Python, stereorecal, its dependencies and each strategy's distribution.
        rows: by the name of the experiment or part of one: validity, sweeps, repair, generalise, ex_nihilo, sequential.
        errors: of tasks that failed, by key.
        unfinished: number of tasks left by an interruption, or by the loss of a worker.
        lost: messages of the executor about workers that were lost.
        matcher: what pixels were counted with.
    """

    settings: dict[str, Any]
    versions: dict[str, str]
    rows: dict[str, tuple[Row, ...]]
    errors: dict[str, str]
    unfinished: int
    lost: tuple[str, ...] = ()
    matcher: AbstractMatcher = field(default_factory=SAD)

    @property
    def summary(self) -> dict[str, Any]:
        """Medians and shares over the rows, with those of the paper's own tables."""
        made = {
            "validity": summaries.of_validity,
            "sweeps": summaries.of_sweeps,
            "repair": lambda rows: [summaries.of_published(TABLE_1), *summaries.of_repairs(rows)],
            "generalise": summaries.of_generalisation,
            "ex_nihilo": lambda rows: [summaries.of_published(TABLE_2), *summaries.of_repairs(rows)],
            "sequential": summaries.of_sequences,
        }
        return {name: made[name](rows) for name, rows in self.rows.items() if rows}

    def as_dict(self) -> dict[str, Any]:
        """The content of the JSON file; a missing or non-finite number is None."""
        return json_data(
            {
                "schema": SCHEMA,
                "versions": self.versions,
                "settings": self.settings,
                "unfinished": self.unfinished,
                "errors": self.errors,
                "lost": list(self.lost),
                "summary": self.summary,
                "rows": {name: list(rows) for name, rows in self.rows.items()},
            }
        )


def reproduce(
    log: Log,
    experiments: Sequence[str] = tuple(EXPERIMENTS),
    *,
    schedules: Sequence[str] = ("count", "default"),
    strategy: str | None = None,
    matcher: AbstractMatcher | str | None = None,
    extent: Extent | None = None,
    reach: Reach | None = None,
    seed: int = 0,
    output: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Reproduction:
    """Run the paper's experiments (section 4) on a log of missions.

    Each pair is counted in one view and with one disparity range, measured with its mission's manual calibration.
    Ctrl-C ends the run; finished tasks are returned, and saved in `output`, where the next run with the same arguments
    continues.

    Args:
        experiments: of "validity", "repair", "generalise", "ex-nihilo", "sequential".
        schedules: "count" (the paper's way) and "default" (coarse to fine), both or one of them.
        strategy: takes the place of compass, or of the fit between matches if it needs residuals.
        matcher: counts pixels and repairs; a matcher, or the name of an installed one (default "sad").
        extent: the part of the log that is used; default as much as in the paper.
        reach: default 3 degrees and 3 % of the baseline.
        seed: chooses wrong calibrations, images and orders.
        output: folder for the rows; default none.
        executor: any `concurrent.futures.Executor`; default one task after the other in this process.
        progress: called with (finished, total) after each task.

    Raises:
        InputError: if a name is unknown, a strategy is not installed, or `output` holds another run.
    """
    for name in experiments:
        if name not in EXPERIMENTS:
            raise InputError(f"unknown experiment {name!r}; choose from: {', '.join(EXPERIMENTS)}.")
    if not experiments or not set(schedules) <= {"count", "default"} or not schedules:
        raise InputError("there is nothing to run; give at least one experiment, and schedules from: count, default.")
    reach, extent, matcher = reach or Reach(), extent or Extent(), as_matcher(matcher)
    chosen = methods(tuple(schedules), strategy)
    installed = versions()
    made_with = installed | {
        f"strategy {type(stage.strategy).__name__}": origin_of(stage.strategy)
        for method in chosen
        for stage in method.schedule.stages
        if stage.strategy is not None
    }
    made_with[f"matcher {name_of(matcher)}"] = origin_of_matcher(matcher)
    settings = {
        "log": _log_settings(log),
        "strategy": strategy,
        "matcher": _matcher_settings(matcher),
        "extent": {**asdict(extent), "matchers": [_matcher_settings(matcher) for matcher in extent.matchers]},
        "reach": asdict(reach),
        "seed": seed,
    }
    store = None if output is None else Store(Path(output), {**settings, "versions": installed})
    planned = _planned(Setting(log, chosen, matcher, extent, reach, seed), experiments)
    rows, errors, lost = _run(planned, store, executor, progress)
    names = list(dict.fromkeys(plan.__name__ for name in experiments for plan in EXPERIMENTS[name]))
    found = {
        name: tuple(rows[key] for key in planned if key in rows and key.partition(":")[0] == name) for name in names
    }
    settings |= {"experiments": list(experiments), "schedules": list(schedules)}
    return Reproduction(settings, made_with, found, errors, len(planned) - len(rows) - len(errors), lost, matcher)


def run_task(task: Task) -> Row | str:
    """Do a task, in a worker. An error comes back as text, which always pickles."""
    try:
        return task.run()
    except Exception as error:
        return str(error) or repr(error)


def _planned(setting: Setting, experiments: Sequence[str]) -> dict[str, Task]:
    planned: dict[str, Task] = {}
    for plan in dict.fromkeys(plan for name in experiments for plan in EXPERIMENTS[name]):
        for task in plan(setting):
            key = f"{plan.__name__}:{task.key}"
            if key in planned:
                raise InputError(f"two tasks are called {key}; give each kind of matcher once.")
            planned[key] = task
    return planned


def _run(
    planned: Mapping[str, Task], store: Store | None, executor: Executor | None, progress: Progress | None
) -> tuple[dict[str, Row], dict[str, str], tuple[str, ...]]:
    """The rows and the errors of tasks, by key, and the messages about lost workers, whose tasks are unfinished."""
    rows = {key: row for key, row in (store.rows if store else {}).items() if key in planned}
    errors: dict[str, str] = {}
    lost: dict[str, None] = {}
    left = [key for key in planned if key not in rows]
    try:
        for index, found in run_all(run_task, [planned[key] for key in left], executor):
            key = left[index]
            if isinstance(found, dict):
                rows[key] = store.add(key, found) if store else json_data(found)
            elif isinstance(found, str):
                errors[key] = found
            else:
                lost[str(found) or repr(found)] = None
            if progress is not None:
                progress(len(rows) + len(errors), len(planned))
        hold()
    except KeyboardInterrupt:
        pass
    return rows, errors, tuple(lost)


def _log_settings(log: Log) -> dict[str, Any]:
    return {
        "name": log.name,
        "calibrations": {name: _digest(_leaves(rig)) for name, rig in log.calibrations.items()},
        "missions": {
            mission.name: {
                "calibration": mission.calibration,
                "images": list(names_of(mission.pairs)),
                "starred": sorted(mission.starred),
                "image_size": list(mission.pairs[0].size),
                "pixels": _digest(image for pair in mission.pairs for image in (pair.left, pair.right)),
                "truth": None if mission.truth is None else _digest(_leaves(mission.truth)),
            }
            for mission in log.missions
        },
    }


def _matcher_settings(matcher: AbstractMatcher) -> dict[str, Any]:
    return {"name": name_of(matcher), **asdict(matcher)}


def _leaves(rig: StereoRig) -> Iterator[np.ndarray]:
    """All numbers of a rig."""
    return (np.asarray(leaf) for leaf in jax.tree.leaves(rig))


def _digest(arrays: Iterable[np.ndarray]) -> str:
    """A digest of all numbers."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(array.tobytes())
    return found.hexdigest()[:12]
