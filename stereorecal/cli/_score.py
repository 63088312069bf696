"""`python -m stereorecal score`."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from stereorecal._environment import versions
from stereorecal._errors import InputError
from stereorecal._signals import hold
from stereorecal.cli import _values
from stereorecal.cli._console import print_lines, table_console
from stereorecal.cli._exit_codes import BAD_INPUT, CANNOT_TELL, INTERRUPTED, REPAIR
from stereorecal.cli._json import write_json
from stereorecal.cli._places import check_places, deliver, image_inputs, places_of, spare
from stereorecal.cli._recordings import recordings
from stereorecal.cli._streams import say
from stereorecal.cli.arguments._motion import motion_of
from stereorecal.decision import Tolerances
from stereorecal.io import about, files_read
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.recalibration import HEALTH_LIMITS, Condition, Health, health
from stereorecal.recordings import Scene
from stereorecal.report.repair_tables import scores_table

SCHEMA = "stereorecal.health/2"
_CODES = {Condition.REPAIR: REPAIR, Condition.CANNOT_TELL: CANNOT_TELL, Condition.HEALTHY: 0}  # the first that occurs


def run(options: argparse.Namespace) -> int:
    """Check, save, print; returns the exit code."""
    matcher = as_matcher(options.matcher)
    limits, shown = _values.tolerances(options), _values.view(options)
    places = places_of(options, "json")
    check_places(places, force=options.force)
    with files_read() as read:
        scenes = recordings(options).scenes
    spare(places, {*read, *image_inputs(options)})
    looked: list[Health | InputError] = []
    interrupted = False
    try:
        for scene in scenes:
            how = {"prior": options.prior, "motion": motion_of(options), "tolerances": limits, "view": shown}
            looked.append(_look(scene, matcher, **how))
        hold()
    except KeyboardInterrupt:
        interrupted = True
    rows = [_row(scene, found) for scene, found in zip(scenes, looked, strict=False)]
    if any(isinstance(found, Health) for found in looked):
        content = {**_about_all(options, matcher, limits), "interrupted": interrupted, "scenes": rows}
        deliver(lambda: _show(looked, rows, options), lambda: _save(content, options))
    for found in looked:
        if isinstance(found, InputError):
            say(found)
    if interrupted:
        say(f"interrupted; {len(looked)} of {len(scenes)} recordings were finished.")
        return INTERRUPTED
    if any(isinstance(found, InputError) for found in looked):
        return BAD_INPUT
    conditions = {found.condition for found in looked if isinstance(found, Health)}
    return next(code for condition, code in _CODES.items() if condition in conditions)


def _save(content: dict[str, Any], options: argparse.Namespace) -> None:
    if options.json is not None:
        write_json(content, options.json, force=options.force)


def _show(looked: Sequence[Health | InputError], rows: Sequence[dict[str, Any]], options: argparse.Namespace) -> None:
    if options.quiet or options.json == "-":
        return
    if len(looked) > 1:
        console = table_console()
        console.print(scores_table(rows, console.width))
    elif looked and isinstance(looked[0], Health):
        print_lines(looked[0])


def _look(scene: Scene, matcher: AbstractMatcher, **how: Any) -> Health | InputError:
    """What there is to say of a recording: one that cannot be used does not take the others with it."""
    assert scene.rig is not None
    try:
        with about(scene.name):
            return health(scene.rig, scene.pairs, matcher=matcher, **how)
    except InputError as error:
        return error


def _row(scene: Scene, found: Health | InputError) -> dict[str, Any]:
    about_it = {"scene": scene.name, "frames": len(scene.pairs), "image_size": scene.pairs[0].size}
    if isinstance(found, InputError):
        return {**about_it, "error": str(found)}
    return {**about_it, "error": None, **found.as_dict()}


def _about_all(options: argparse.Namespace, matcher: AbstractMatcher, limits: Tolerances) -> dict[str, Any]:
    settings = {
        "frames": options.frames,
        "motion": options.motion,
        "matcher": {"name": options.matcher, **asdict(matcher)},
        "view": options.view,
        "thresholds": {**HEALTH_LIMITS, **limits.limits},
        "distances": limits.distances,
    }
    return {"schema": SCHEMA, "versions": versions(), "settings": settings}
