"""`python -m stereorecal score`."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from stereorecal._versions import versions
from stereorecal.cli import _values
from stereorecal.cli._console import table_console
from stereorecal.cli._exit_codes import CANNOT_TELL, INTERRUPTED, REPAIR
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
    scenes = recordings(options)
    looked: list[Health] = []
    interrupted = False
    try:
        for scene in scenes:
            looked.append(_look(scene, matcher))
    except KeyboardInterrupt:
        interrupted = True
    if looked:
        rows = [
            {"scene": scene.name, "frames": len(scene.pairs), "image_size": scene.pairs[0].size, **found.as_dict()}
            for scene, found in zip(scenes, looked, strict=False)
        ]
        if options.json is not None:
            write_json({**_about_all(options, matcher), "interrupted": interrupted, "scenes": rows}, options.json)
        if not options.quiet and options.json != "-":
            _show(looked, rows)
    if interrupted:
        print(f"stereorecal: interrupted; {len(looked)} of {len(scenes)} recordings were finished.", file=sys.stderr)
        return INTERRUPTED
    conditions = {found.condition for found in looked}
    return next(code for condition, code in _CODES.items() if condition in conditions)


def _show(looked: Sequence[Health], rows: Sequence[dict[str, Any]]) -> None:
    if len(looked) > 1:
        table_console().print(scores_table(rows))
    else:
        print(looked[0])


def _look(scene: Scene, matcher: AbstractMatcher) -> Health:
    assert scene.rig is not None
    with about(scene.name):
        return health(scene.rig, scene.pairs, matcher=matcher)


def _about_all(options: argparse.Namespace, matcher: AbstractMatcher) -> dict[str, Any]:
    settings = {
        "frames": options.frames,
        "matcher": {"name": options.matcher, **asdict(matcher)},
        "thresholds": dict(HEALTH_LIMITS),
    }
    return {"schema": SCHEMA, "versions": versions(), "settings": settings}
