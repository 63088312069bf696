"""`python -m stereorecal score`."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from stereorecal._errors import InputError
from stereorecal._versions import versions
from stereorecal.cli import _values
from stereorecal.cli._console import table_console
from stereorecal.cli._exit_codes import BAD_INPUT, CANNOT_TELL, INTERRUPTED, REPAIR
from stereorecal.cli._json import write_json
from stereorecal.cli._recordings import recordings
from stereorecal.io import about
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.recalibration import HEALTH_LIMITS, Condition, Health, health
from stereorecal.recordings import Scene
from stereorecal.report.repairs import scores_table

SCHEMA = "stereorecal.health/1"
_CODES = {Condition.REPAIR: REPAIR, Condition.CANNOT_TELL: CANNOT_TELL, Condition.HEALTHY: 0}  # the first that occurs


def run(options: argparse.Namespace) -> int:
    """Check, save, print; returns the exit code."""
    matcher = as_matcher(options.matcher)
    _values.output_path(options.json, "--json")
    scenes = recordings(options).scenes
    looked: list[Health | InputError] = []
    interrupted = False
    try:
        for scene in scenes:
            looked.append(_look(scene, matcher))
    except KeyboardInterrupt:
        interrupted = True
    rows = [_row(scene, found) for scene, found in zip(scenes, looked, strict=False)]
    if options.json is not None and any(isinstance(found, Health) for found in looked):
        write_json({**_about_all(options, matcher), "interrupted": interrupted, "scenes": rows}, options.json)
    if not options.quiet and options.json != "-" and any(isinstance(found, Health) for found in looked):
        _show(looked, rows)
    for found in looked:
        if isinstance(found, InputError):
            print(f"stereorecal: {found}", file=sys.stderr)
    if interrupted:
        print(f"stereorecal: interrupted; {len(looked)} of {len(scenes)} recordings were finished.", file=sys.stderr)
        return INTERRUPTED
    if any(isinstance(found, InputError) for found in looked):
        return BAD_INPUT
    conditions = {found.condition for found in looked if isinstance(found, Health)}
    return next(code for condition, code in _CODES.items() if condition in conditions)


def _show(looked: Sequence[Health | InputError], rows: Sequence[dict[str, Any]]) -> None:
    if len(looked) > 1:
        table_console().print(scores_table(rows))
    elif looked and isinstance(looked[0], Health):
        print(looked[0])


def _look(scene: Scene, matcher: AbstractMatcher) -> Health | InputError:
    """What there is to say of a recording: one that cannot be used does not take the others with it."""
    assert scene.rig is not None
    try:
        with about(scene.name):
            return health(scene.rig, scene.pairs, matcher=matcher)
    except InputError as error:
        return error


def _row(scene: Scene, found: Health | InputError) -> dict[str, Any]:
    about_it = {"scene": scene.name, "frames": len(scene.pairs), "image_size": scene.pairs[0].size}
    if isinstance(found, InputError):
        return {**about_it, "error": str(found)}
    return {**about_it, "error": None, **found.as_dict()}


def _about_all(options: argparse.Namespace, matcher: AbstractMatcher) -> dict[str, Any]:
    settings = {
        "frames": options.frames,
        "matcher": {"name": options.matcher, **asdict(matcher)},
        "thresholds": dict(HEALTH_LIMITS),
    }
    return {"schema": SCHEMA, "versions": versions(), "settings": settings}
