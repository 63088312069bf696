"""Stdout and stderr: closed, without a reader, on a full disk, or on a terminal that cannot write everything."""

import io
import os
import re
import select
import sys
from typing import Any

from stereorecal._errors import InputError

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


class _Unfailing(io.FileIO):
    """A file whose writes succeed: what cannot be printed is no reason to lose what is not saved yet.

    Attributes:
        error: of the first write that failed.
    """

    error: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            while (written := super().write(data)) is None:  # somebody has made it non-blocking, and it is full
                select.select([], [self], [])
            return written
        except OSError as error:
            self.error = self.error or error
            return len(data)


def secure() -> None:
    """Let no print fail from now on; what is closed becomes /dev/null, so that no file takes its number."""
    while (spare := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(spare)
    for number, name in ((1, "stdout"), (2, "stderr")):
        was, raw = getattr(sys, name), _Unfailing(number, "w", closefd=False)
        encoding, lines = getattr(was, "encoding", None), number == 2 or raw.isatty()
        # What a terminal cannot write, such as ± in ASCII, is spelt \xb1.
        text = io.TextIOWrapper(io.BufferedWriter(raw), encoding, "backslashreplace", line_buffering=lines)
        setattr(sys, name, text)


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


def say(message: object) -> None:
    """A line on stderr. Control characters, as names of files may hold, are spelt: a terminal would obey them."""
    print(f"stereorecal: {_CONTROL.sub(lambda sign: repr(sign[0])[1:-1], str(message))}", file=sys.stderr)
