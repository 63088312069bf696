"""The files that a command writes: one that fails costs no other."""

import sys
from collections.abc import Callable, Mapping
from typing import Any

from stereorecal._errors import InputError
from stereorecal.cli._signals import held
from stereorecal.cli._streams import say
from stereorecal.io import json_text, write_text


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
