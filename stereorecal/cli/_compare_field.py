"""`python -m stereorecal compare --judge …` and `--preset field`."""

import math
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from stereorecal._choices import checked_choice
from stereorecal._errors import InputError
from stereorecal.cli import _option_values
from stereorecal.cli._executors import executor
from stereorecal.cli._exit_codes import FAILURE, INTERRUPTED
from stereorecal.cli._experiment_commands import CompareOptions
from stereorecal.cli._html_page import check_page
from stereorecal.cli._journals import TrialJournal
from stereorecal.cli._output_files import deliver, write_json
from stereorecal.cli._output_places import check_places, check_writable, places_of, refuse_replacing_inputs
from stereorecal.cli._streams import say
from stereorecal.cli._terminal import progress_bar, table_console
from stereorecal.comparison.field import FAILED, Field, compare_field, methods_of, planned
from stereorecal.comparison.judges import RENDERED, Draws, recipes_of
from stereorecal.io import files_read
from stereorecal.matching import as_matcher
from stereorecal.objectives import Reach
from stereorecal.report.field_tables import field_tables

PRESETS = ("field",)
_FRAMES = ("rendered", "simulated")  # judges that are told how many pairs
_SPARING, _FULL = {"number": 10, "rides": 4}, {"number": 40, "rides": 20, "walk": 1000}
_OTHERS = ("scene", "synthetic", "schedule", "scale", "budget")  # options of comparisons of strategies


def run(options: CompareOptions) -> int:
    """Compare, print, save; returns the exit code."""
    _check_options(options)
    judges = [*(RENDERED if options.preset else ()), *options.judge]
    draws = _draws(options)
    reach = Reach(*_option_values.degrees_and_fraction(options.reach, "--reach")) if options.reach is not None else None
    matcher = as_matcher(options.matcher)
    methods = methods_of(None if options.strategies in (None, "all") else options.strategies.split(","))
    places = places_of(options, "html", "json")
    check_page(options.html, "field_page")
    with files_read() as read:
        recipes = [recipe for judge in judges for recipe in recipes_of(judge, draws)]
    empty, tasks = planned(judges, recipes, methods, matcher=matcher, draws=draws, reach=reach)
    made_with = {
        name: value for name, value in empty.as_dict().items() if name in ("schema", "versions", "settings", "methods")
    }
    for place in places:
        check_writable(place)
    files = [place.path for place in places if place.path.is_file() or not place.path.exists()]
    journal = TrialJournal(files, made_with)
    check_places([place for place in places if not journal.owns(place.path)], force=options.force)
    check_places(places, force=True)
    refuse_replacing_inputs(places, read)

    def may_replace(place: str) -> bool:
        return options.force or journal.owns(Path(place))

    if journal.done:
        say(f"{len(journal.done)} of {len(tasks)} trials were finished already; going on.")
    html, data = options.html, options.json
    with executor(options.executor) as pool, _progress(options) as progress:
        journal.begin()
        field = compare_field(
            empty, tasks, done=journal.done, executor=pool, progress=progress, on_trial=journal, on_loss=_say_lost
        )
        deliver(
            lambda: _show(field, options),
            lambda: write_json(field.as_dict(), data, force=data is not None and may_replace(data)),
            lambda: field.to_html(html, overwrite=may_replace(html)) if html is not None else None,
        )
    if field.interrupted:
        again = f"; the same command goes on from {journal.path}" if journal.path is not None else ""
        say(f"interrupted; {len(field.trials)} of {field.planned} trials were finished{again}.")
        return INTERRUPTED
    journal.finish()
    return FAILURE if all(trial.status == FAILED for trial in field.trials) else 0


def _check_options(options: CompareOptions) -> None:
    if options.preset is not None:
        checked_choice(options.preset, PRESETS, "preset")
    if options.full and options.preset is None:
        raise InputError("--full belongs to --preset field; leave it out, or add that.")
    for name in _OTHERS:
        if getattr(options, name):
            raise InputError(f"--{name} belongs to comparisons of strategies; leave it out with judges (--judge).")
    others = [judge for judge in options.judge if judge.partition("=")[0].strip() not in _FRAMES]
    if options.frames is not None and others:
        raise InputError(
            f"--frames applies to the judges {' and '.join(_FRAMES)}; leave it out with --judge {others[0]}, which has "
            "pairs of its own."
        )
    if options.free != "extrinsics":
        raise InputError(
            "--free belongs to comparisons of strategies; with judges, what a method may change is a column."
        )


def _draws(options: CompareOptions) -> Draws:
    chosen = Draws()
    if options.preset:
        chosen = replace(chosen, **(_FULL if options.full else _SPARING))
    if options.draws is not None:
        if options.draws < 1:
            raise InputError(f"--draws is {options.draws}; give 1 or more.")
        chosen = replace(chosen, number=options.draws, rides=options.draws)
    degrees, fraction = _option_values.degrees_and_fraction(options.decalibrate, "--decalibrate")
    frames = _option_values.frame_limit(options.frames, "1")
    if frames is None:
        raise InputError("--frames all has no meaning for judges that are rendered; give a number.")
    if options.square is not None and not (math.isfinite(options.square) and options.square > 0.0):
        raise InputError(f"--square is {options.square}; give metres, such as 0.03.")
    return replace(
        chosen,
        seed=_option_values.seed(options.seed),
        degrees=degrees,
        baseline_fraction=fraction,
        frames=frames,
        corners=_option_values.board_corners(options.board_corners),
        square=options.square,
    )


def _progress(options: CompareOptions):
    """A bar where somebody looks; else a line now and then, since it takes long."""
    if options.quiet or sys.stderr.isatty():
        return progress_bar(options.quiet, "judging")
    return nullcontext(_line)


def _line(finished: int, total: int) -> None:
    if finished and (finished == total or finished % max(1, total // 20) == 0):
        say(f"{finished} of {total} trials")


def _say_lost(error: BaseException) -> None:
    say(f"a worker was lost, such as for want of memory; its trials and those behind it are missing ({error})")


def _show(field: Field, options: CompareOptions) -> None:
    if field.trials and options.prints:
        console = table_console()
        console.print(field_tables(field.as_dict()))
