"""`python -m stereorecal score`."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from stereorecal._errors import InputError
from stereorecal.cli._library_arguments import library_options, run_as_json, settings_as_json
from stereorecal.cli._output_files import deliver, write_json
from stereorecal.cli._places import refuse_replacing_inputs
from stereorecal.cli._recordings import recordings, rig_of
from stereorecal.cli._repair_commands import ScoreOptions
from stereorecal.cli._signals import BAD_INPUT, CANNOT_TELL, INTERRUPTED, REPAIR, WRONG_INPUT, hold
from stereorecal.cli._streams import say
from stereorecal.cli._terminal import print_lines, progress_bar, table_console
from stereorecal.io import about, files_read
from stereorecal.recalibration import HEALTH_LIMITS, Condition, HealthOptions, Solution, as_settings, health
from stereorecal.recordings import Scene

SCHEMA = "stereorecal.health/4"
CODES = {  # the first that occurs
    Condition.WRONG_INPUT: WRONG_INPUT,
    Condition.REPAIR: REPAIR,
    Condition.CANNOT_TELL: CANNOT_TELL,
    Condition.HEALTHY: 0,
}


def run(options: ScoreOptions) -> int:
    """Check, save, print; returns the exit code."""
    how = library_options(options, HealthOptions.__optional_keys__)
    settings = as_settings(how, HealthOptions.__optional_keys__)
    with files_read() as read:
        scenes = recordings(options).scenes
    refuse_replacing_inputs(options.places, {*read, *options.image_inputs})
    looked: list[Solution | InputError] = []
    interrupted = False
    try:
        with progress_bar(options.quiet, "checking") as progress:
            for scene in scenes:
                looked.append(_health_or_error(scene, how))
                if progress is not None:
                    progress(len(looked), len(scenes))
        hold()
    except KeyboardInterrupt:
        interrupted = True
    told = zip(scenes, looked, strict=False) if options.json or len(looked) > 1 else ()  # a text needs no data
    rows = [_row(scene, found) for scene, found in told]
    solutions = [found for found in looked if isinstance(found, Solution)]
    refusals = [found for found in looked if isinstance(found, InputError)]
    if solutions:
        names = sorted((HealthOptions.__optional_keys__ | {"pairs", "fix"}) - {"tolerances"})
        limits = {"thresholds": {**HEALTH_LIMITS, **asdict(settings.tolerances)}}
        told = settings_as_json(options, settings, names) | limits
        content = run_as_json(SCHEMA, told, interrupted=interrupted, scenes=rows)
        deliver(lambda: _show(looked, rows, options), lambda: write_json(content, options.json, force=options.force))
    for refusal in refusals:
        say(refusal)
    if interrupted:
        say(f"interrupted; {len(looked)} of {len(scenes)} recordings were finished.")
        return INTERRUPTED
    if refusals:
        return BAD_INPUT
    conditions = {found.condition for found in solutions}
    return next(code for condition, code in CODES.items() if condition in conditions)


def _show(looked: Sequence[Solution | InputError], rows: Sequence[dict[str, Any]], options: ScoreOptions) -> None:
    if not options.prints:
        return
    if len(looked) > 1:
        from stereorecal.report.repair_tables import scores_table

        console = table_console()
        console.print(scores_table(rows, console.width))
    elif looked and isinstance(looked[0], Solution):
        print_lines(looked[0])


def _health_or_error(scene: Scene, how: dict[str, Any]) -> Solution | InputError:
    """What there is to say of a recording: one that cannot be used does not take the others with it."""
    try:
        with about(scene.name):
            return health(rig_of(scene), scene.pairs, **how)
    except InputError as error:
        return error


def _row(scene: Scene, found: Solution | InputError) -> dict[str, Any]:
    about_it = {"scene": scene.name, "frames": len(scene.pairs), "image_size": scene.pairs[0].size}
    if isinstance(found, InputError):
        return {**about_it, "error": str(found)}
    return {**about_it, "error": None, **found.to_dict()}
