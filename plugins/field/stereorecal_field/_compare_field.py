"""`python -m stereorecal compare --judge …` and `--preset field`."""

import math
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from stereorecal_boards import board_corners

from stereorecal import InputError, Reach
from stereorecal.cli import (
    FAILURE,
    INTERRUPTED,
    GrowingJson,
    check_extra,
    check_places,
    deliver,
    executor,
    progress_bar,
    refuse_replacing_inputs,
    say,
    table_console,
    value_of,
    write_json,
)
from stereorecal.io import files_read, json_text, parse_json, read_json
from stereorecal.matching import as_matcher
from stereorecal_field._options import JudgeOptions
from stereorecal_field.judges import RENDERED, Draws, recipes_of
from stereorecal_field.table import (
    FAILED,
    Field,
    FieldTrial,
    as_trial,
    compare_field,
    field_tables,
    methods_of,
    planned,
)

_FRAMES = ("rendered", "simulated")  # judges that are told how many pairs
_SPARING, _FULL = {"number": 10, "rides": 4}, {"number": 40, "rides": 20, "walk": 1000}
_OTHERS = ("scene", "synthetic", "schedule", "scale", "budget")  # options of comparisons of strategies


def run(options: JudgeOptions) -> int:
    """Compare, print, save; returns the exit code."""
    _check_options(options)
    judges = [*(RENDERED if options.preset else ()), *options.judge]
    draws = _draws(options)
    reach = None if options.reach is None else Reach(*value_of(options, "reach"))
    matcher = as_matcher(options.matcher)
    methods = methods_of(None if options.strategies in (None, "all") else options.strategies.split(","))
    check_extra(options, "html", "figures", "stereorecal_field.table._field_page")
    with files_read() as read:
        recipes = [recipe for judge in judges for recipe in recipes_of(judge, draws)]
    empty, tasks = planned(judges, recipes, methods, matcher=matcher, draws=draws, reach=reach)
    done = _finished(options.json, empty)
    check_places([one for one in options.places if done is None or one.option != "--json"], force=options.force)
    check_places(options.places, force=True)
    refuse_replacing_inputs(options.places, read)
    if done:
        say(f"{len(done)} of {len(tasks)} trials were finished already; going on.")
    html, growing = options.html, GrowingJson(options.json, force=options.force or done is not None)
    with executor(options.executor) as pool, _progress(options) as progress:
        field = compare_field(
            empty, tasks, done=done, executor=pool, progress=progress, on_trial=growing, on_loss=_say_lost
        )
        deliver(
            lambda: _show(field, options),
            lambda: write_json(field.as_dict(), options.json, force=growing.force),
            lambda: field.to_html(html, overwrite=options.force) if html is not None else None,
        )
    if field.interrupted:
        say(f"interrupted; {len(field.trials)} of {field.planned} trials were finished{_again(options)}.")
        return INTERRUPTED
    return FAILURE if all(trial.status == FAILED for trial in field.trials) else 0


def _finished(target: str | None, empty: Field) -> dict[str, FieldTrial] | None:
    """The trials, by key, in the file of --json, if an earlier run of this very comparison did not end; else None."""
    if target is None or not Path(target).is_file():
        return None
    now = parse_json(json_text(empty.as_dict()))
    try:
        before = read_json(target)
        same = all(before[name] == now[name] for name in ("schema", "versions", "settings", "methods"))
        trials = [as_trial(row) for row in before["trials"]] if same and before["interrupted"] else None
    except (InputError, TypeError, ValueError, KeyError, AttributeError):  # it is something else
        return None
    return None if trials is None else {trial.key: trial for trial in trials}


def _again(options: JudgeOptions) -> str:
    if options.json in (None, "-"):
        return ""
    page = "" if options.html is None else ", with --force, since the page is there already"
    return f"; the same command goes on from {options.json}{page}"


def _check_options(options: JudgeOptions) -> None:
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


def _draws(options: JudgeOptions) -> Draws:
    chosen = Draws()
    if options.preset:
        chosen = replace(chosen, **(_FULL if options.full else _SPARING))
    if options.draws is not None:
        if options.draws < 1:
            raise InputError(f"--draws is {options.draws}; give 1 or more.")
        chosen = replace(chosen, number=options.draws, rides=options.draws)
    degrees, fraction = value_of(options, "decalibrate")
    frames = value_of(options, "frames", 1)
    if frames is None:
        raise InputError("--frames all has no meaning for judges that are rendered; give a number.")
    if options.square is not None and not (math.isfinite(options.square) and options.square > 0.0):
        raise InputError(f"--square is {options.square}; give metres, such as 0.03.")
    return replace(
        chosen,
        seed=options.seed,
        degrees=degrees,
        baseline_fraction=fraction,
        frames=frames,
        corners=board_corners(options.board_corners),
        square=options.square,
    )


def _progress(options: JudgeOptions):
    """A bar where somebody looks; else a line now and then, since it takes long."""
    if options.quiet or sys.stderr.isatty():
        return progress_bar(options.quiet, "judging")
    return nullcontext(_line)


def _line(finished: int, total: int) -> None:
    if finished and (finished == total or finished % max(1, total // 20) == 0):
        say(f"{finished} of {total} trials")


def _say_lost(error: BaseException) -> None:
    say(f"a worker was lost, such as for want of memory; its trials and those behind it are missing ({error})")


def _show(field: Field, options: JudgeOptions) -> None:
    if field.trials and options.prints:
        console = table_console()
        console.print(field_tables(field.as_dict()))
