"""How a command ends: its exit codes; and Ctrl-C, SIGTERM (a cron job's end) and SIGHUP (a closed terminal), after
which finished results are saved, and the run ends.

While libraries are imported a signal ends the process, since an exception raised there may come out as anything. Later
it raises KeyboardInterrupt, and once all is finished it waits until that is saved. A terminal that is closed sends
several signals: those within a second are one.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

REPAIR, BAD_INPUT, FAILURE, CANNOT_TELL, WRONG_INPUT = 1, 2, 3, 4, 5
INTERRUPTED = 130
_TOGETHER_S = 1.0
_NUMBERS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class _Run:
    """Whether results are being saved, and a signal waits for that; when the last signal came, and which one (0: none
    has come)."""

    saving, waiting, came, last = False, False, 0, 0.0


_run = _Run()


def end_at_once() -> None:
    """Until `interruptible`, a signal ends the process with one line and exit code 130."""
    _handle_with(_exit_on_signal)


@contextmanager
def interruptible() -> Iterator[None]:
    """Inside, a signal raises KeyboardInterrupt; but see `hold`. Only in the main thread."""
    vars(_run).clear()
    before, hook = {number: signal.getsignal(number) for number in _NUMBERS}, sys.unraisablehook
    sys.unraisablehook = _raise_later
    try:
        _handle_with(_interrupt)
        yield
        _release()
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def interrupted() -> bool:
    """Whether a signal has come."""
    return bool(_run.came)


def hold() -> None:
    """Let signals wait until the end of `held`: all is finished, and about to be saved."""
    _run.saving = True


@contextmanager
def held() -> Iterator[None]:
    """Inside, a signal waits until the end: results are being saved. A second one does not wait."""
    hold()
    try:
        yield
    finally:
        _run.saving = False
    _release()


def _handle_with(handler: Any) -> None:
    """A signal that is ignored (nohup, &) stays so."""
    for number in _NUMBERS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _release() -> None:
    if _run.waiting:
        _run.waiting = False
        raise KeyboardInterrupt


def _counts() -> bool:
    """Whether the signal that has just come is not one with those before it."""
    before, _run.last = _run.last, time.monotonic()
    return not before or _run.last - before > _TOGETHER_S


def _exit_on_signal(number: int, frame: FrameType | None) -> None:
    if _counts():
        with suppress(OSError):
            os.write(2, b"stereorecal: interrupted\n")
        os._exit(INTERRUPTED)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if not _counts():
        return
    _run.came, _run.waiting = number, _run.saving and not _run.waiting
    if not _run.waiting:
        raise KeyboardInterrupt


def _raise_later(unraisable: Any) -> None:
    """Python prints and forgets what a finaliser or a callback raises: the signal is sent again when it is left."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        _run.last = 0.0
        threading.Timer(0.01, os.kill, [os.getpid(), _run.came or signal.SIGINT]).start()
    else:
        sys.__unraisablehook__(unraisable)
