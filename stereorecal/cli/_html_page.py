"""Pages and recordings of a repair: what is refused before the work is done, and what is written."""

import importlib
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from stereorecal._errors import InputError, as_input_error, extra
from stereorecal.cli._repair_commands import RecalibrateOptions
from stereorecal.cli._shared_options import RerunOptions
from stereorecal.recalibration import Repair
from stereorecal.recordings import Scene


def check_page(html: str | None, module: str) -> None:
    """Refuse, before the work is done, a page that could not be made.

    Args:
        html: the value of --html.
        module: that makes the page.

    Raises:
        InputError: says what to do.
    """
    if html is None:
        return
    with extra("figures", "--html"):
        importlib.import_module(module)
    if html == "-":
        raise InputError("--html - has no meaning; give a file.")


def check_rerun(options: RerunOptions, module: str) -> None:
    """Refuse, before the work is done, a recording that could not be made or shown.

    Args:
        module: that makes the recording.

    Raises:
        InputError: says what to do.
    """
    if options.rrd is None and not options.show:
        return
    with extra("rerun", "--rrd" if options.rrd is not None else "--show"):
        importlib.import_module(module)
        streams = importlib.import_module("stereorecal.report.rerun_streams")
    if options.rrd == "-":
        raise InputError("--rrd - has no meaning; give a file.")
    if options.show:
        with as_input_error(streams.NoViewer):
            streams.check_screen()


def write_report(
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


def write_recording(options: RecalibrateOptions, scenes: Sequence[Scene], repairs: Sequence[Repair]) -> None:
    """The recording of the only repair, into a file and on the screen, if one is wanted and there is an answer."""
    solution = repairs[0].solution
    if solution is None:
        return
    for place in [options.rrd] * (options.rrd is not None) + [None] * options.show:
        solution.to_rerun(place, scenes[0].pairs, name=scenes[0].name, overwrite=options.force)
        if place is not None and options.prints:
            print(f"{place}: written")
