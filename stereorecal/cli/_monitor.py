"""`python -m stereorecal monitor`."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import IO, Any

from stereorecal._errors import InputError
from stereorecal.cli._live_view import Lines, check_rerun, live, rerun_watch, undetermined
from stereorecal.cli._options import value_of
from stereorecal.cli._output_files import deliver, written_or_printed
from stereorecal.cli._places import check_places, named_inputs, refuse_replacing_inputs
from stereorecal.cli._recordings import rig_of, watched, watched_cameras
from stereorecal.cli._repair_commands import MonitorOptions
from stereorecal.cli._score import CODES
from stereorecal.cli._signals import BAD_INPUT, CANNOT_TELL, INTERRUPTED, hold
from stereorecal.cli._streams import say, stdout_reader_gone
from stereorecal.geometry import StereoRig
from stereorecal.io import calibration_json, check_savable, files_read, json_line, save_rig
from stereorecal.matching import as_matcher
from stereorecal.online import (
    EVENTS_SCHEMA,
    Advice,
    Config,
    Reading,
    State,
    Stepped,
    advice,
    init,
    load,
    reading,
    run as steps,
    save,
)
from stereorecal.recalibration import Condition
from stereorecal.recordings import Scene


def run(options: MonitorOptions) -> int:
    """Check, watch, save; returns the exit code."""
    appended = options.goes_on and _is_log(options.json)
    if not appended:
        check_places([place for place in options.places if place.option == "--json"], force=options.force)
    check_rerun(options)
    with files_read() as read:
        scene, pairs = watched(options) if options.camera is None else watched_cameras(options)
    refuse_replacing_inputs(options.places, {*read, *options.image_inputs, *named_inputs(options.camera)})
    if options.output is not None:
        check_savable(rig_of(scene), value_of(options, "output"))
    state, interrupted = _start(options, rig_of(scene)), False
    began, unread, sure = state.frame, 0, not options.until_sure
    log_rerun, save_rerun = rerun_watch(options, scene.name)
    failed: dict[str, Exception] = {}  # what could not be read or written; the rest goes on

    def attempt(step: Callable[[], None], what: str) -> None:
        try:
            if what not in failed:
                step()
        except InputError as error:
            failed[what] = error

    try:
        with _json_lines(options, appended) as write, _shown_steps(options, scene) as show:
            for stepped in steps(state, pairs):
                state, unread = stepped.state, unread + (stepped.pair is None)
                if options.state is not None:
                    attempt(partial(save, state, options.state), "state")
                attempt(partial(write, stepped), "events")
                log_rerun(stepped)
                found = advice(stepped.state) if options.prints or options.until_sure else None
                if found is not None:
                    show(stepped, found)
                if stdout_reader_gone() and not (options.output or options.state or options.rrd or options.show):
                    return 0  # nothing is left to be done
                sure = sure or (found is not None and found.stands)
                if options.until_sure and sure:
                    break
            hold()
    except KeyboardInterrupt:
        interrupted = True
        say(f"interrupted after {_pairs(state.frame - began)}.")
    except InputError as error:  # a pair that cannot be read: what the others have told is kept
        if state.frame == began:
            raise
        failed["a pair"] = error
    deliver(
        lambda: _save_output(options, state, scene),
        save_rerun,
        lambda: _summary(options, state),
        *(partial(_raise, error) for error in failed.values()),
    )
    if unread:
        say(f"{unread} of {state.frame - began} pairs cannot be read; check the files.")
    if interrupted:
        return INTERRUPTED
    if 2 * unread > state.frame - began:
        return BAD_INPUT
    condition = reading(state).condition
    if sure:
        return CODES[condition]
    if not options.quiet:
        missing = undetermined(advice(state), float(state.initial.baseline))
        seen = _pairs(state.frame - began)
        say(f"the recording ended, after {seen}, before this was sure; not determined: {missing}.")
    return CANNOT_TELL if condition is Condition.HEALTHY else CODES[condition]


def _pairs(number: int) -> str:
    return f"{number} pair{'s' * (number != 1)}"


def _save_output(options: MonitorOptions, state: State, scene: Scene) -> None:
    if options.output is None or not state.using.any():
        return
    target = value_of(options, "output")
    rig = replace(state.rig, source=rig_of(scene).source)  # what was restored from a file has forgotten its own
    written_or_printed(
        lambda: save_rig(rig, target, scene.info, overwrite=options.force),
        lambda: calibration_json(rig),
        to_stdout=options.json != "-",
    )


def _summary(options: MonitorOptions, state: State) -> None:
    if options.prints:
        found = reading(state)
        print(f"{found.condition.value}{_reason(found)}; {_calibration_note(options, state)}")


def _reason(found: Reading) -> str:
    """Why nothing can be told; nothing where something can."""
    if found.condition is not Condition.CANNOT_TELL:
        return ""
    if found.late:
        return f" (the right shutter is late by {found.delay.value:.2f} of a frame)"
    return f" (epipolar error {max(found.rows_px.low, 0.0):.2f} to {found.rows_px.high:.2f} px with 95 %)"


def _raise(error: Exception) -> None:
    raise error


def _start(options: MonitorOptions, rig: StereoRig) -> State:
    view_options = value_of(options, "view", {})
    said: dict[str, Any] = {"repair": not options.once}  # what is not said is as it is by default, or in the state
    if options.synchronous:
        said["synchronous"] = True
    if options.tolerances is not None:
        said["tolerances"] = value_of(options, "tolerances")
    if options.state is not None and options.goes_on:
        state = load(options.state, rig)
        if state.config.view != state.config.view | view_options:
            raise InputError(f"--view: the state in {options.state} was made with another view; leave --view out.")
        return state.configured(replace(state.config, **said))
    return init(rig, Config(matcher=as_matcher(options.matcher), **said, **view_options))


def _calibration_note(options: MonitorOptions, state: State) -> str:
    if not state.using.any():
        note = "the calibration in use is the one that was given"
        return note if options.output is None else f"{note}; {options.output} is not written"
    if options.output is None:
        return "the calibration in use is a repaired one; --output FILE would write it"
    return f"the calibration in use is a repaired one, written to {options.output}"


def _event_lines(stepped: Stepped) -> Iterator[str]:
    """The events of a step, and what the state reads after it."""
    yield from (json_line(event.as_dict()) for event in stepped.events)
    about = {"schema": EVENTS_SCHEMA, "frame": stepped.state.frame - 1, "event": "reading"}
    yield json_line({**about, **reading(stepped.state).as_dict()})


def _is_log(path: str | None) -> bool:
    """Whether a file holds what an earlier run has told."""
    if path is None or not Path(path).is_file():
        return False
    with open(path, "rb") as file, suppress(ValueError):
        first = json.loads(file.readline(1 << 16))
        return isinstance(first, dict) and first.get("schema") == EVENTS_SCHEMA
    return False


@contextmanager
def _json_lines(options: MonitorOptions, appended: bool) -> Iterator[Callable[[Stepped], None]]:
    """What writes the events of a step; the file is opened by the first, so that none is left of a watch without."""
    file: IO[str] | None = sys.stdout if options.json == "-" else None

    def write(stepped: Stepped) -> None:
        nonlocal file
        if options.json is None:
            return
        try:
            if file is None:
                file = _opened(options.json, appended, options.force)
            file.writelines(_event_lines(stepped))
            file.flush()
        except FileExistsError:
            why = "a file has appeared there; choose another or add --force"
            raise InputError(f"--json {options.json}: {why}.") from None
        except OSError as error:
            why = f"cannot be written ({error.strerror}); make room"
            raise InputError(f"--json {options.json}: {why}.") from error

    try:
        yield write
    finally:
        if file is not None and file is not sys.stdout:
            with suppress(OSError):  # said when it was written
                file.close()


def _opened(target: str, appended: bool, force: bool) -> IO[str]:
    """The file of the events, at its end."""
    cut_short = False
    if appended:
        with open(target, "rb") as before:
            before.seek(-1, 2)
            cut_short = before.read() != b"\n"  # by a loss of power
    # What was not there before the work began is nobody else's; a device is.
    mode = "a" if appended else "w" if force or (Path(target).exists() and not Path(target).is_file()) else "x"
    file = open(target, mode, encoding="utf-8")  # noqa: SIM115  closed when the watch ends
    if cut_short:
        file.write("\n")  # the last line spoils no other
    return file


def _shown_steps(options: MonitorOptions, scene: Scene) -> AbstractContextManager[Callable[[Stepped, Advice], None]]:
    """What is called with each step: a live view in a terminal, else events as lines."""
    if not options.prints:
        return nullcontext(lambda stepped, found: None)
    return live(scene.name) if sys.stdout.isatty() else nullcontext(Lines())
