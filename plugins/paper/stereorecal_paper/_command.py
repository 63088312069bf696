"""`python -m stereorecal reproduce`."""

from pathlib import Path
from typing import Any

from stereorecal import InputError
from stereorecal.cli import (
    FAILURE,
    INTERRUPTED,
    checked_choice,
    deliver,
    executor,
    progress_bar,
    refuse_replacing_inputs,
    say,
    table_console,
    value_of,
    write_json,
)
from stereorecal.io import files_read, load_log
from stereorecal.matching import as_matcher
from stereorecal.objectives import Reach
from stereorecal.recalibration import SCHEDULES
from stereorecal.recordings import Log
from stereorecal_paper._experiments import EXPERIMENTS, QUICK, Extent, methods
from stereorecal_paper._options import ReproduceOptions
from stereorecal_paper._reproduce import reproduce
from stereorecal_paper._result_files import write_files
from stereorecal_paper._row_store import store_files
from stereorecal_paper._synthetic_log import synthetic_log
from stereorecal_paper._tables import experiment_tables

_ALL = "all"
_WIDE = 150  # columns of the widest table


def run(options: ReproduceOptions) -> int:
    """Run, save, print; returns the exit code."""
    chosen = [checked_choice(name, [*EXPERIMENTS, _ALL], "experiment") for name in options.experiments]
    experiments = list(EXPERIMENTS) if _ALL in chosen else list(dict.fromkeys(chosen))
    reach = Reach(*value_of(options, "reach"))
    if options.frames is not None and options.log is None:
        raise InputError("--frames belongs to --log; leave it out, or give a log.")
    schedules = SCHEDULES if options.schedule == "both" else (options.schedule,)
    matcher = as_matcher(options.matcher)
    methods(schedules, options.strategy)  # what is not installed is said before a log is rendered
    with executor(options.executor) as workers:
        with files_read() as read:
            log = _log(options)
        folder = Path(options.output or f"reproduced/{log.name.rpartition('/')[2]}")
        refuse_replacing_inputs(options.places, [*read, *store_files(folder)])
        for place in options.places:
            if place.path.resolve().parent == folder.resolve():
                raise InputError(f"{place}: --output {folder} takes its own files only; choose another place.")
        with progress_bar(options.quiet) as progress:
            found = reproduce(
                log,
                experiments,
                schedules=schedules,
                strategy=options.strategy,
                matcher=matcher,
                extent=QUICK if options.quick else Extent(),
                reach=reach,
                seed=options.seed,
                output=folder,
                executor=workers,
                progress=progress,
            )
        # Before the workers are waited for: a second Ctrl-C must find everything saved.
        data = found.as_dict()
        deliver(
            lambda: _show(data, options),
            lambda: write_json(data, options.json, force=options.force),
            lambda: write_files(found, log, folder),
        )
    for key, error in found.errors.items():
        say(f"{key}: {error}")
    if not options.quiet:
        say(f"tables and figures are in {folder}")
    for message in found.lost:
        say(f"a worker was lost: {message}")
    if found.unfinished:
        why = "workers were lost" if found.lost else "interrupted"
        say(f"{why}; {found.unfinished} tasks are left: run it again.")
        return FAILURE if found.lost else INTERRUPTED
    return FAILURE if found.errors and not any(found.rows.values()) else 0


def _show(data: dict[str, Any], options: ReproduceOptions) -> None:
    if options.prints:
        table_console(_WIDE).print(experiment_tables(data))


def _log(options: ReproduceOptions) -> Log:
    if options.log is not None:
        return load_log(Path(options.log), value_of(options, "frames", 10))
    with progress_bar(options.quiet, "rendering") as progress:
        return synthetic_log(options.seed, quick=options.quick, progress=progress)
