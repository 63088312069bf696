"""`python -m stereorecal recalibrate`."""

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import zip_longest
from typing import Any

from stereorecal._run_all import Progress
from stereorecal.cli._calibration_output import Output, output_of, save, what_it_holds
from stereorecal.cli._executors import executor
from stereorecal.cli._library_arguments import library_options, run_as_json, settings_as_json
from stereorecal.cli._options import value_of
from stereorecal.cli._output_files import check_extra, deliver, write_json, written_or_printed
from stereorecal.cli._places import named_inputs
from stereorecal.cli._recordings import recordings, rig_of
from stereorecal.cli._repair_commands import RecalibrateOptions
from stereorecal.cli._signals import BAD_INPUT, CANNOT_TELL, FAILURE, INTERRUPTED, WRONG_INPUT, hold
from stereorecal.cli._streams import say
from stereorecal.cli._terminal import print_lines, progress_bar, table_console
from stereorecal.estimation import DEFAULT, SAVED
from stereorecal.io import calibration_json, files_read, save_maps
from stereorecal.recalibration import (
    Fault,
    Repair,
    RepairOptions,
    Settings,
    Solution,
    as_settings,
    recalibrate_many,
    saved_with,
)
from stereorecal.recordings import Scene
from stereorecal.report.number_text import short_list

SCHEMA = "stereorecal.solution/3"
_CODES = {Fault.INTERRUPTED: INTERRUPTED, Fault.INSIDE: FAILURE, Fault.INPUT: BAD_INPUT}  # the first that occurs


def run(options: RecalibrateOptions) -> int:
    """Repair, save, print; returns the exit code."""
    how = library_options(options, RepairOptions.__optional_keys__)
    settings = as_settings(how)
    check_extra(options, "html", "figures", "stereorecal.report.repair_page")
    check_extra(options, "rrd", "rerun", "stereorecal.report.repair_recording")
    with executor(options.executor) as pool:
        with files_read() as read:
            # Ranges name pairs of the whole recording.
            few = settings.free.everything or bool(settings.free.shared)
            found = recordings(options, few=few and not settings.ranges)
            rigs = [rig_of(scene) for scene in found.scenes]
            settings = replace(settings, prior=options.known_of(rigs))
        read |= set(named_inputs(options.ranges, options.odometer))
        priors = [] if options.prior else [saved_with(rig)[0] for rig in rigs]
        output = output_of(options, rigs[0], settings.free.names, read)
        settings = replace(settings, free=what_it_holds(output, rigs[0], settings))
        scenes = found.scenes
        pairing = {"pairing": found.pairing} if found.pairing else {}
        common = how | {"prior": settings.prior, "free": settings.free, "executor": pool}
        with progress_bar(options.quiet) as progress:
            repairs, interrupted = _recalibrated_all(scenes, progress, common)
        # Before the workers are waited for: a second Ctrl-C must find everything saved.
        if any(repair.solution for repair in repairs):
            prior = options.prior or (SAVED if any(priors) else DEFAULT)
            prior = {"prior": prior if settings.prior is options.prior else "given"}
            about = {"settings": {**_page_settings(options, settings), **prior, **pairing}, "absent": found.absent}
            steps = [partial(_show, repairs, options)]
            if options.json is not None:
                told = settings_as_json(options, settings, [*vars(settings), "stages", "pairs", "fix"]) | prior
                rows = [_row(scene, repair) for scene, repair in zip(scenes, repairs, strict=True)]
                content = run_as_json(SCHEMA, told, interrupted=interrupted, repairs=rows)
                steps.append(partial(write_json, content, options.json, force=options.force))
            if (first := repairs[0].solution) is not None:
                steps += [
                    partial(_save_calibration, options, first, scenes[0], output),
                    partial(_save_maps, options, first),
                    partial(_save_page, options, first, scenes[0], about),
                    partial(_save_recording, options, first, scenes[0]),
                ]
            deliver(*steps)
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


def _page_settings(options: RecalibrateOptions, settings: Settings) -> dict[str, Any]:
    """What a page says of the settings in the words of the command, beside what its solution knows."""
    names = "everything" if settings.free.everything else ", ".join(settings.free.names)
    output = {} if options.output is None else {"output": options.output}
    return {"free": names, "ranges": options.ranges or "none", **output}


def _save_calibration(options: RecalibrateOptions, found: Solution, scene: Scene, output: Output) -> None:
    """Write the calibration to use, if it is another than before, and what is known of it."""
    if not (found.accepted or (found.reason.healthy and options.fix == "scaled")):
        for path in output.files:
            options.tell(f"{path}: not written, since the initial calibration stays")
    elif output.files:
        copies = written_or_printed(
            lambda: save(found, output, scene, options),
            lambda: calibration_json(found.rig, found.prior),
            to_stdout=options.json != "-",
        )
        for path, copy in zip_longest(output.files, copies):
            options.tell(f"{path}: written{output.note}" + (f"; the old one is {copy}" if copy else ""))
        if output.prior_path is not None:
            options.tell(f"{output.prior_path}: written; keep it with the calibration, for the next repair")


def _save_maps(options: RecalibrateOptions, found: Solution) -> None:
    """Write the maps of the calibration to use, if that is good."""
    maps = options.maps
    if maps is not None and found.reason.healthy:
        written_or_printed(
            lambda: save_maps(found.rig, maps, options.force, value_of(options, "view")),
            lambda: calibration_json(found.rig, found.prior),
            to_stdout=options.json != "-",
        )
        options.tell(f"{maps}: written{'' if found.accepted else ' for the initial calibration'}")
    elif maps is not None:
        options.tell(f"{maps}: not written, since the initial calibration stays")


def _save_page(options: RecalibrateOptions, found: Solution, scene: Scene, about: Mapping[str, Any]) -> None:
    if options.html is not None:
        command = shlex.join(["python", "-m", "stereorecal", *options.words])
        how = {"name": scene.name, "command": command, "overwrite": options.force}
        found.to_html(options.html, scene.pairs, **how, **about)
        options.tell(f"{options.html}: written")


def _save_recording(options: RecalibrateOptions, found: Solution, scene: Scene) -> None:
    if options.rrd is not None:
        found.to_rerun(options.rrd, scene.pairs, name=scene.name, overwrite=options.force)
        options.tell(f"{options.rrd}: written")


def _row(scene: Scene, repair: Repair) -> dict[str, Any]:
    return {**repair.as_dict(), "frames": len(scene.pairs), "image_size": scene.pairs[0].size}


def _show(repairs: Sequence[Repair], options: RecalibrateOptions) -> None:
    if not options.prints:
        return
    if len(repairs) == 1:
        print_lines(repairs[0].solution)
        return
    from stereorecal.report.repair_tables import repairs_table

    console = table_console()
    console.print(repairs_table([repair.as_dict() for repair in repairs], console.width))
    names: dict[str, list[str]] = {}
    for repair in repairs:
        if repair.solution and (found := repair.solution.intrinsics):
            names.setdefault(str(found), []).append(repair.name)
    for line, some in names.items():
        print_lines(line if len(some) == len(repairs) else f"{short_list(some)}: {line}")


def _exit_code(repairs: Sequence[Repair]) -> int:
    faults = {repair.fault for repair in repairs}
    for fault, code in _CODES.items():
        if fault in faults:
            return code
    solutions = [repair.solution for repair in repairs if repair.solution]
    if any(one.mismatch for one in solutions):
        return WRONG_INPUT
    wrong = {one.reason for one in solutions if not one.reason.healthy}
    return CANNOT_TELL if wrong and all(reason.undetermined for reason in wrong) else int(bool(wrong))
