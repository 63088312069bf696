"""Stdout: a terminal that cannot write everything, a disk that is full, or a pipe that nobody reads any more."""

import codecs
import io
import os
import re
import select
import sys
from contextlib import suppress

from stereorecal._errors import InputError

_ASCII = {"±": "+-", "°": " deg", "…": "...", "×": "x", "²": "^2", "→": "->", "≥": ">=", "≤": "<="}  # noqa: RUF001

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


def spell_out() -> None:
    """From now on, what a terminal or a file cannot write is written otherwise, such as +- for ±."""
    codecs.register_error("stereorecal", _spelt)
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="stereorecal")


def say(message: object) -> None:
    """A line on stderr. Control characters, as names of files may hold, are spelt: a terminal would obey them."""
    print(f"stereorecal: {_CONTROL.sub(lambda sign: repr(sign[0])[1:-1], str(message))}", file=sys.stderr)


def flush() -> None:
    """Write what stdout holds back. A pipe that was closed has seen enough.

    Raises:
        InputError: if it cannot be written.
    """
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        leave_stdout()
    except OSError as error:
        raise stdout_error(error) from error


def stdout_error(error: OSError) -> InputError:
    """Nothing more goes to stdout; what to say of it."""
    leave_stdout()
    return InputError(f"stdout: cannot be written ({error.strerror}); make room, or give --json FILE.")


def stdout_reader_closed() -> bool:
    """Whether it is stdout whose reader has gone: a BrokenPipeError does not say which pipe it is about."""
    if hasattr(select, "poll"):
        with suppress(OSError, ValueError):  # stdout is no file
            poll = select.poll()
            poll.register(sys.stdout.fileno(), 0)
            return bool(poll.poll(0))
    return True


def leave_stdout() -> None:
    """What is still held back goes nowhere: Python writes it at its end, and would complain."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _spelt(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_ASCII.get(sign, "?") for sign in error.object[error.start : error.end]), error.end
