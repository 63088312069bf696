"""`python -m stereorecal monitor`."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import IO

from stereorecal._errors import InputError
from stereorecal.cli._exit_codes import CANNOT_TELL, INTERRUPTED, REPAIR
from stereorecal.cli._live import lines, live
from stereorecal.cli._places import check_places, check_writable, places_of
from stereorecal.cli._recordings import recordings
from stereorecal.io import check_savable, json_line, save_rig
from stereorecal.matching import as_matcher
from stereorecal.online import Config, State, Stepped, init, load, reading, run as steps, save
from stereorecal.recalibration import Condition
from stereorecal.recordings import Scene

_CODES = {Condition.HEALTHY: 0, Condition.REPAIR: REPAIR, Condition.CANNOT_TELL: CANNOT_TELL}


def run(options: argparse.Namespace) -> int:
    """Check, watch, save; returns the exit code."""
    _check_places(options)
    scenes = recordings(options).scenes
    if len(scenes) != 1:
        raise InputError("one rig is watched at a time; give one scene.")
    assert scenes[0].rig is not None
    if options.output is not None:
        check_savable(scenes[0].rig, options.output)
    state, interrupted = _start(options, scenes[0]), False
    try:
        with _json_lines(options.json) as log, _shown(options, scenes[0]) as show:
            for stepped in steps(state, scenes[0].pairs):
                state = stepped.state
                if options.state is not None:
                    save(state, options.state)
                if log is not None:
                    log.writelines(_told(stepped))
                    log.flush()
                show(stepped)
    except KeyboardInterrupt:
        interrupted = True
        print(f"stereorecal: interrupted after {state.frame} pairs.", file=sys.stderr)
    if options.output is not None and state.using.any():
        rig = replace(state.rig, source=scenes[0].rig.source)  # what was restored from a file has forgotten its own
        save_rig(rig, options.output, scenes[0].info, overwrite=options.force)
    condition = reading(state).condition
    if not options.quiet and options.json != "-":
        print(f"{condition.value}; {_about(options, state)}")
    return INTERRUPTED if interrupted else _CODES[condition]


def _start(options: argparse.Namespace, scene: Scene) -> State:
    config = Config(matcher=as_matcher(options.matcher), repair=not options.once)
    if options.state is not None and Path(options.state).exists():
        kept = load(options.state)
        return kept.but(config=replace(config, matcher=kept.config.matcher))
    assert scene.rig is not None
    return init(scene.rig, config)


def _about(options: argparse.Namespace, state: State) -> str:
    if not state.using.any():
        return "the calibration is the one that was given"
    if options.output is None:
        return "it is a repaired one; --output FILE would write it"
    return f"it is a repaired one, written to {options.output}"


def _told(stepped: Stepped) -> Iterator[str]:
    """The events of a step, and what the state reads after it."""
    yield from (json_line(event.as_dict()) for event in stepped.events)
    about = {"schema": "stereorecal.events/1", "frame": stepped.state.frame - 1, "event": "reading"}
    yield json_line({**about, **reading(stepped.state).as_dict()})


@contextmanager
def _json_lines(target: str | None) -> Iterator[IO[str] | None]:
    if target is None or target == "-":
        yield None if target is None else sys.stdout
        return
    with open(target, "w", encoding="utf-8") as file:
        yield file


@contextmanager
def _shown(options: argparse.Namespace, scene: Scene):
    """What is called with each step: a live view in a terminal, else events as lines."""
    if options.quiet or options.json == "-":
        yield lambda stepped: None
        return
    with ExitStack() as stack:
        yield stack.enter_context(live(scene.name)) if sys.stdout.isatty() else lines


def _check_places(options: argparse.Namespace) -> None:
    for place in places_of(options, "json", "state"):
        check_writable(place)
    if options.output == "-":
        raise InputError("--output -: a calibration is written to a file; give the name of one.")
    check_places(places_of(options, "output"), force=options.force)
