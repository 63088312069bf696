"""`python -m stereorecal compare`."""

from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli._executors import executor
from stereorecal.cli._experiment_commands import CompareOptions
from stereorecal.cli._library_arguments import library_options
from stereorecal.cli._option_values import strategy_names
from stereorecal.cli._options import value_of
from stereorecal.cli._output_files import GrowingJson, check_extra, deliver, write_json
from stereorecal.cli._places import refuse_replacing_inputs
from stereorecal.cli._signals import FAILURE, INTERRUPTED
from stereorecal.cli._streams import say
from stereorecal.cli._terminal import progress_bar, table_console
from stereorecal.comparison import FAILED, Comparison, ComparisonOptions, Drift, compare_scenes
from stereorecal.io import files_read, load_scene
from stereorecal.matching import as_matcher
from stereorecal.objectives import as_parameters, as_reach
from stereorecal.recordings import Scene
from stereorecal.report.comparison_tables import comparison_tables
from stereorecal.strategies import as_budget
from stereorecal.synthetic import render

_DRAWS = 2


def run(options: CompareOptions) -> int:
    """Compare, print, save; returns the exit code."""
    if options.schedule == "default" and options.scale is not None:
        raise InputError("--scale belongs to --schedule count; leave it out.")
    how = {"draws": _DRAWS, **library_options(options, ComparisonOptions.__optional_keys__ - {"strategies"})}
    if options.strategies is not None:
        how["strategies"] = strategy_names(options.strategies)
    how["drift"] = Drift(*value_of(options, "decalibrate"))
    for name, read in (("matcher", as_matcher), ("reach", as_reach), ("budget", as_budget), ("free", as_parameters)):
        if name in how:  # what makes no sense is refused before a scene is read
            how[name] = read(how[name])
    check_extra(options, "html", "figures", "stereorecal.report.comparison_page")
    html, journal = options.html, GrowingJson(options.json, force=options.force)
    with executor(options.executor) as pool:
        with files_read() as read:
            scenes = _scenes(options)
        refuse_replacing_inputs(options.places, read)
        with progress_bar(options.quiet) as progress:
            comparison = compare_scenes(scenes, executor=pool, progress=progress, on_trial=journal, **how)
        # Before the workers are waited for: a second Ctrl-C must find everything saved.
        deliver(
            lambda: _show(comparison, options),
            lambda: write_json(comparison.as_dict(), options.json, force=journal.force),
            lambda: comparison.to_html(html, overwrite=options.force) if html is not None else None,
        )
    if comparison.interrupted:
        say(f"interrupted; trials finished: {len(comparison.trials)}.")
        return INTERRUPTED
    return FAILURE if all(trial.status == FAILED for trial in comparison.trials) else 0


def _scenes(options: CompareOptions) -> list[Scene]:
    limit = value_of(options, "frames", 1)
    scenes = [load_scene(Path(path), limit=limit) for path in options.scene]
    if options.synthetic or not scenes:
        if limit is None:
            raise InputError("--frames all has no meaning for a rendered scene; give a number.")
        scenes.append(render(options.synthetic or "harbour", options.seed, frames=limit))
    return scenes


def _show(comparison: Comparison, options: CompareOptions) -> None:
    if comparison.trials and options.prints:
        console = table_console()
        console.print(comparison_tables(comparison.as_dict(), console.width))
