"""`python -m stereorecal recalibrate`."""

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal._run_all import Progress
from stereorecal._version import versions
from stereorecal.cli import _calibration_output
from stereorecal.cli._executors import executor
from stereorecal.cli._library_arguments import library_options, settings_as_json
from stereorecal.cli._options import value_of
from stereorecal.cli._output_files import check_page, check_rerun, deliver, write_json, written_or_printed
from stereorecal.cli._places import named_inputs
from stereorecal.cli._recordings import left_out_pairs, recordings
from stereorecal.cli._repair_commands import RecalibrateOptions
from stereorecal.cli._signals import BAD_INPUT, CANNOT_TELL, FAILURE, INTERRUPTED, WRONG_INPUT, hold
from stereorecal.cli._streams import say
from stereorecal.cli._terminal import print_lines, progress_bar, table_console
from stereorecal.estimation import DEFAULT, SAVED
from stereorecal.io import calibration_json, files_read, save_maps
from stereorecal.objectives import Parameters
from stereorecal.recalibration import (
    Fault,
    Repair,
    RepairOptions,
    Settings,
    Solution,
    as_settings,
    recalibrate_many,
    saved_with,
    sharing,
)
from stereorecal.recordings import Scene
from stereorecal.report.repair_tables import repairs_table
from stereorecal.strategies import origin_of

SCHEMA = "stereorecal.solution/2"
_CODES = {Fault.INTERRUPTED: INTERRUPTED, Fault.INSIDE: FAILURE, Fault.INPUT: BAD_INPUT}  # the first that occurs


def run(options: RecalibrateOptions) -> int:
    """Repair, save, print; returns the exit code."""
    settings = as_settings(library_options(options, RepairOptions.__optional_keys__))
    check_page(options.html, "stereorecal.report.repair_page")
    check_rerun(options, "stereorecal.report.repair_recording")
    shown = [f"--{name}" for name in ("html", "rrd", "show") if getattr(options, name)]
    if shown and len(options.scenes) > 1:
        raise InputError(f"{shown[0]} shows one recording; give one, or leave {shown[0]} out.")
    with executor(options.executor) as pool:
        with files_read() as read:
            # Ranges name pairs of the whole recording: it is cut down once they are found.
            few = settings.free.everything or bool(settings.free.shared)
            found = recordings(options, few=few and not settings.ranges)
            settings = replace(settings, prior=options.known_of([scene.rig for scene in found.scenes]))
        read |= set(named_inputs(options.ranges, options.odometer))
        priors = [None if scene.rig is None or options.prior else saved_with(scene.rig)[0] for scene in found.scenes]
        output = _calibration_output.output_of(options, found.scenes, settings.free.names, read)
        held = _calibration_output.what_it_holds(output, found.scenes[0].rig, settings)
        settings = replace(settings, free=held)
        shared = sharing(found.scenes, settings.free, settings.ranges, settings.schedule)
        scenes, ranges = shared
        absent = found.absent + left_out_pairs(found.scenes[0].pairs, scenes[0].pairs, "others show more texture")
        pairing = {"pairing": found.pairing} if found.pairing else {}
        del found
        common = {"ranges": ranges, "executor": pool}
        with progress_bar(options.quiet) as progress:
            repairs, interrupted = _recalibrated_all(scenes, progress, {**settings.options, **common})
        # Before the workers are waited for: a second Ctrl-C must find everything saved.
        if any(repair.solution for repair in repairs):
            prior = options.prior or (SAVED if any(priors) else DEFAULT)
            prior = prior if settings.prior is options.prior else "given"
            content = _content(
                scenes, repairs, {**_settings_as_json(options, settings), "prior": prior}, interrupted=interrupted
            )
            deliver(
                lambda: _show(repairs, options),
                *_saving(scenes, repairs, options, output),
                lambda: write_json(content, options.json, force=options.force),
                lambda: _write_page(
                    options,
                    scenes,
                    repairs,
                    {**_page_settings(options, settings.free), "prior": prior, **pairing},
                    absent,
                ),
                lambda: _write_recording(options, scenes, repairs),
            )
    for repair in repairs:
        if repair.error is not None:
            if options.traceback and repair.traceback is not None:
                print(repair.traceback, file=sys.stderr)
            say(f"{repair.name}: {repair.error}")
    return INTERRUPTED if interrupted else _exit_code(repairs)


def _recalibrated_all(
    scenes: Sequence[Scene], progress: Progress | None, arguments: dict[str, Any]
) -> tuple[tuple[Repair, ...], bool]:
    """All repairs, in the order of the scenes, and whether Ctrl-C came first: those that it has left are faults, and
    what recordings share is not solved then."""
    interrupted = Fault.INTERRUPTED
    finished = [Repair(scene.name, error=interrupted.value, fault=interrupted) for scene in scenes]
    try:
        found = recalibrate_many(scenes, finished=finished.__setitem__, progress=progress, **arguments)
        hold()
    except KeyboardInterrupt:
        if all(repair.fault is not interrupted for repair in finished):
            say("interrupted; what recordings share was not solved.")
        return tuple(finished), True
    return found, False


def _settings_as_json(options: RecalibrateOptions, settings: Settings) -> dict[str, Any]:
    """What was asked for and computed with."""
    stages = [
        {
            "score": stage.score.name.lower(),
            "scale": stage.scale,
            "strategy": stage.solver,
            "origin": None if stage.strategy is None else origin_of(stage.strategy),
            "options": {} if stage.strategy is None else asdict(stage.strategy),
        }
        for stage in settings.schedule.stages
    ]
    return {
        **settings_as_json(options, settings, settings.options),
        "schedule": settings.schedule.name,
        "stages": stages,
        "free": ("everything",) if settings.free.everything else settings.free.names,
        "pairs": options.pairs,
        "fix": options.fix,
    }


def _page_settings(options: RecalibrateOptions, free: Parameters) -> dict[str, Any]:
    """What a page says of the settings beside what its solution knows: a repair of extrinsics may know nothing of what
    was solved for afterwards."""
    names = "everything" if free.everything else ", ".join(free.names)
    return {"free": names, "ranges": options.ranges or "none"}


def _saving(
    scenes: Sequence[Scene], repairs: Sequence[Repair], options: RecalibrateOptions, output: _calibration_output.Output
) -> list[Callable[[], None]]:
    """Steps that write the calibration and the maps, and say so."""
    first, maps = repairs[0].solution, options.maps
    accepted, good = first is not None and first.accepted, first is not None and first.reason.healthy

    def step(names: Sequence[Path], wanted: bool, save: Callable[[Solution], list[Path] | None], note: str) -> None:
        """`save` returns the copies of what it replaced, if there are any."""
        copies: list[Path] = []
        if first is not None and wanted:
            found = first
            written_or_printed(
                lambda: copies.extend(save(found) or ()),
                lambda: calibration_json(found.rig, found.prior),
                to_stdout=options.json != "-",
            )
        notes = [f"written{note}; the old one is {copy}" for copy in copies] or [f"written{note}"] * len(names)
        for name, done in zip(names, notes, strict=True) if options.prints else ():
            print(f"{name}: {done if wanted else 'not written, since the initial calibration stays'}")

    def save_calibration() -> None:
        wanted = accepted or (good and options.fix == "scaled")
        how = (output, scenes[0], options)
        step(output.files, wanted, lambda found: _calibration_output.save(found, *how), output.note)
        if options.prints and wanted and output.prior_path is not None:
            print(f"{output.prior_path}: written; keep it with the calibration, for the next repair")

    def save_seen(maps: str) -> None:
        how = (maps, options.force, value_of(options, "view"))
        initial = "" if accepted else " for the initial calibration"
        step([Path(maps)], good, lambda found: save_maps(found.rig, *how), initial)

    return [save_calibration] * bool(output.files) + ([lambda: save_seen(maps)] if maps else [])


def _write_page(
    options: RecalibrateOptions,
    scenes: Sequence[Scene],
    repairs: Sequence[Repair],
    settings: Mapping[str, Any],
    absent: Sequence[tuple[str, str]],
) -> None:
    """The page of the only recording, if one is wanted and there is an answer.

    Args:
        settings: what is needed to run it again beside what a solution knows.
        absent: frames that did not come to the repair, and why.
    """
    solution = repairs[0].solution
    if options.html is None or solution is None:
        return
    command = shlex.join(["python", "-m", "stereorecal", *options.words])
    pairs, name = scenes[0].pairs, scenes[0].name
    about = {"name": name, "command": command, "settings": settings, "absent": absent}
    solution.to_html(options.html, pairs, **about, overwrite=options.force)
    if options.prints:
        print(f"{options.html}: written")


def _write_recording(options: RecalibrateOptions, scenes: Sequence[Scene], repairs: Sequence[Repair]) -> None:
    """The recording of the only repair, into a file and on the screen, if one is wanted and there is an answer."""
    solution = repairs[0].solution
    if solution is None:
        return
    for place in [options.rrd] * (options.rrd is not None) + [None] * options.show:
        solution.to_rerun(place, scenes[0].pairs, name=scenes[0].name, overwrite=options.force)
        if place is not None and options.prints:
            print(f"{place}: written")


def _content(
    scenes: Sequence[Scene], repairs: Sequence[Repair], settings: dict[str, Any], *, interrupted: bool
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "versions": versions(),
        "settings": settings,
        "interrupted": interrupted,
        "repairs": [
            {**repair.as_dict(), "frames": len(scene.pairs), "image_size": scene.pairs[0].size}
            for scene, repair in zip(scenes, repairs, strict=True)
        ],
    }


def _show(repairs: Sequence[Repair], options: RecalibrateOptions) -> None:
    if not options.prints:
        return
    if len(repairs) > 1:
        console = table_console()
        console.print(repairs_table([repair.as_dict() for repair in repairs], console.width))
        shared = [repair.solution.intrinsics for repair in repairs if repair.solution and repair.solution.intrinsics]
        for line in dict.fromkeys(map(str, shared)):  # each once
            print_lines(line)
        return
    print_lines(repairs[0].solution)


def _exit_code(repairs: Sequence[Repair]) -> int:
    faults = {repair.fault for repair in repairs}
    for fault, code in _CODES.items():
        if fault in faults:
            return code
    solutions = [repair.solution for repair in repairs if repair.solution]
    if any(one.mismatch for one in solutions):
        return WRONG_INPUT
    reasons = {one.reason for one in solutions}
    wrong = {reason for reason in reasons if not reason.healthy}
    return CANNOT_TELL if wrong and all(reason.undetermined for reason in wrong) else int(bool(wrong))
