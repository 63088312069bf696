"""Stdin, stdout and stderr, made safe where they are closed or without a reader."""

import io
import os
import sys
from typing import Any


def secure() -> None:
    """What is closed becomes /dev/null, so that no file takes its number; stderr never fails: what cannot be said is
    no reason to lose what is finished."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:
        os.set_inheritable(number, True)
    os.close(number)
    if sys.stdin is None:
        sys.stdin = open(0, closefd=False)  # noqa: SIM115  as long as the process
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    encoding = getattr(sys.stderr, "encoding", "utf-8")
    raw = io.BufferedWriter(_Unfailing(2, "w", closefd=False))
    sys.stderr = io.TextIOWrapper(raw, encoding, "backslashreplace", line_buffering=True)


class _Unfailing(io.FileIO):
    """A file whose writes succeed, whatever becomes of them."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data) or len(data)
        except OSError:
            return len(data)
