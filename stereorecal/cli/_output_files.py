"""The files that a command writes: one that fails costs no other, and what is killed has its finished trials there."""

import importlib
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from stereorecal._errors import InputError, as_input_error, extra
from stereorecal.cli._shared_options import RerunOptions
from stereorecal.cli._signals import held
from stereorecal.cli._streams import say
from stereorecal.io import json_text, write_text

_SHARE = 0.05  # of the time, at most, goes into saving


def deliver(*steps: Callable[[], object]) -> None:
    """Print and write, step by step; one that fails costs no other.

    Raises:
        Exception: the first that was raised, once all is tried; the others are said.
    """
    errors: list[Exception] = []
    with held():
        for step in steps:
            try:
                step()
            except Exception as error:
                errors.append(error)
        sys.stdout.flush()
    for error in errors[1:]:
        say(error)
    if errors:
        raise errors[0]


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
    if options.show:
        with as_input_error(streams.NoViewer):
            streams.check_screen()


def written_or_printed(write: Callable[[], None], text: Callable[[], str], *, to_stdout: bool = True) -> None:
    """Write, or print what cannot be written: nothing that is finished is lost.

    Args:
        to_stdout: whether it is printed there; else, where stdout is JSON, to stderr.

    Raises:
        InputError: of `write`.
    """
    try:
        write()
    except (InputError, OSError):
        print(text(), file=sys.stdout if to_stdout else sys.stderr)
        raise


def write_json(content: Mapping[str, Any], target: str | None, *, force: bool) -> None:
    """Write to the file `target`, whole or not at all; for "-" to stdout, for None nowhere. A number that is not
    finite is null.

    Args:
        force: whether a file is replaced that was not there when the command began, but is now.

    Raises:
        InputError: if it cannot be written to the file; it is printed then.
    """
    if target is None:
        return
    text = json_text(dict(content))
    if target == "-":
        sys.stdout.write(text)
    else:
        written_or_printed(lambda: write_text(target, text, replace=force), lambda: text)


class _Table(Protocol):
    def as_dict(self) -> dict[str, Any]: ...


class GrowingJson:
    """A comparison in the file of --json, if that is a file: written whole, again and again."""

    def __init__(self, target: str | None, *, force: bool):
        file = target is not None and target != "-" and (Path(target).is_file() or not Path(target).exists())
        self._target = target if file else None
        self.force = force  # whether what is there may be replaced: it may, once it is this run's own
        self._next = 0.0

    def __call__(self, table: _Table) -> None:
        started = time.monotonic()
        if self._target is None or started < self._next:
            return
        with suppress(InputError):  # said, and printed, at the end
            write_text(self._target, json_text(table.as_dict()), replace=self.force)
            self.force = True
        ended = time.monotonic()
        self._next = ended + (ended - started) / _SHARE
