"""The files that a command writes: one that fails costs no other, and what is killed has its finished trials there."""

import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from stereorecal._errors import InputError, extra
from stereorecal.cli._signals import held
from stereorecal.cli._streams import say
from stereorecal.io import json_text, write_text

_Done = TypeVar("_Done")
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


def check_extra(options: Any, name: str, needs: str, module: str) -> None:
    """Refuse, before the work is done, an output that could not be made.

    Args:
        name: of the option, such as "html".
        needs: the extra that it takes.
        module: that makes it.

    Raises:
        InputError: says what to install.
    """
    if getattr(options, name):
        with extra(needs, f"--{name}"):
            import_module(module)


def written_or_printed(write: Callable[[], _Done], text: Callable[[], str], *, to_stdout: bool = True) -> _Done:
    """What `write` returns; what cannot be written is printed, to stderr where stdout is JSON: nothing that is finished
    is lost."""
    try:
        return write()
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


class GrowingJson:
    """A table (`as_dict()`) in the file of --json, if that is a file: written whole, again and again."""

    def __init__(self, target: str | None, *, force: bool):
        file = target is not None and target != "-" and (Path(target).is_file() or not Path(target).exists())
        self._target = target if file else None
        self.force = force  # whether what is there may be replaced: it may, once it is this run's own
        self._next = 0.0

    def __call__(self, table: Any) -> None:
        started = time.monotonic()
        if self._target is None or started < self._next:
            return
        with suppress(InputError):  # said, and printed, at the end
            write_text(self._target, json_text(table.as_dict()), replace=self.force)
            self.force = True
        ended = time.monotonic()
        self._next = ended + (ended - started) / _SHARE
