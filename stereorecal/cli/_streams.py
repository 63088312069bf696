"""Stdout and stderr: closed, without a reader, on a full disk, or on a terminal that cannot write everything."""

import codecs
import io
import os
import re
import sys
from typing import Any

from stereorecal._errors import InputError

_ASCII = {"±": "+-", "°": " deg", "…": "...", "×": "x", "²": "^2", "→": "->", "≥": ">=", "≤": "<="}  # noqa: RUF001

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


class _Unfailing(io.FileIO):
    """A file whose writes succeed: what cannot be printed is no reason to lose what is not saved yet.

    Attributes:
        error: of the first write that failed.
    """

    error: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data) or len(data)
        except OSError as error:
            self.error = self.error or error
            return len(data)


def secure() -> None:
    """From now on nothing that is printed fails; what is closed becomes /dev/null, so that no file takes its number."""
    while (spare := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(spare)
    for number, name in ((1, "stdout"), (2, "stderr")):
        was, raw = getattr(sys, name), _Unfailing(number, "w", closefd=False)
        how = (getattr(was, "encoding", None), getattr(was, "errors", None))
        lines = number == 2 or raw.isatty()
        setattr(sys, name, io.TextIOWrapper(io.BufferedWriter(raw), *how, line_buffering=lines))


def _failure() -> OSError | None:
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return raw.error if isinstance(raw, _Unfailing) else None


def stdout_error() -> InputError | None:
    """What to say of stdout, if something could not be written there; of a pipe that was closed, nothing."""
    error = _failure()
    if error is None or isinstance(error, BrokenPipeError):
        return None
    return InputError(f"stdout: cannot be written ({error.strerror}); make room, or give --json FILE.")


def stdout_reader_gone() -> bool:
    """Whether stdout is a pipe that was closed: it has seen enough."""
    return isinstance(_failure(), BrokenPipeError)


def spell_out() -> None:
    """From now on, what a terminal or a file cannot write is written otherwise, such as +- for ±."""
    codecs.register_error("stereorecal", _spelt)
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="stereorecal")


def say(message: object) -> None:
    """A line on stderr. Control characters, as names of files may hold, are spelt: a terminal would obey them."""
    print(f"stereorecal: {_CONTROL.sub(lambda sign: repr(sign[0])[1:-1], str(message))}", file=sys.stderr)


def _spelt(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_ASCII.get(sign, "?") for sign in error.object[error.start : error.end]), error.end
