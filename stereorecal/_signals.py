"""Ctrl-C, SIGTERM (a cron job's end) and SIGHUP (a closed terminal): finished results are saved, and the run ends.

As long as nothing is begun, a signal ends the process at once: an exception raised while libraries are imported would
come out as anything, or be swallowed. Later it is a KeyboardInterrupt, and once all is finished it waits until that is
saved. Signals that come together, as when a terminal is closed, are one.
"""

import _thread
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import FrameType
from typing import Any

INTERRUPTED = 130  # exit code
_TOGETHER_S = 1.0  # within which signals are one
_SAVING_S = 20.0  # that saving may take after a signal: a pipe without a reader would take for ever
_NUMBERS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


@dataclass
class _Run:
    """What has happened.

    Attributes:
        holding: whether the first signal waits.
        waiting: whether it does.
        came: the first signal, or 0.
        last: when the last one came that counts.
        limit: ends what takes too long.
    """

    holding: bool = False
    waiting: bool = False
    came: int = 0
    last: float = -math.inf
    limit: threading.Timer | None = None


_run = _Run()


def end_at_once() -> None:
    """Until `interruptible`: one line and exit code 130. A signal that is ignored (nohup, &) stays so."""
    for number in _NUMBERS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _exit_on_signal)


def ignore() -> None:
    """All is said and saved, and the process is about to end."""
    for number in _NUMBERS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def interruptible() -> Iterator[None]:
    """Inside, each signal raises KeyboardInterrupt, again if a library has swallowed it; but see `hold`."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    vars(_run).update(vars(_Run()))
    before = {number: signal.getsignal(number) for number in _NUMBERS}
    unraisable = sys.unraisablehook
    sys.unraisablehook = _reraise_later
    try:
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, _interrupt)
        yield
        _release()
    finally:
        _unlimited()
        sys.unraisablehook = unraisable
        for number, handler in before.items():
            signal.signal(number, handler)


def interrupted() -> bool:
    """Whether a signal has come."""
    return bool(_run.came)


def hold() -> None:
    """From now on, until the end of `held`, the first signal waits: all is finished, and about to be saved."""
    if threading.current_thread() is threading.main_thread():
        _run.holding = True


@contextmanager
def held() -> Iterator[None]:
    """Inside, the first signal waits until the end: results are being saved. A second one does not, and after the first
    saving may not take for ever."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    hold()
    if _run.came:
        _limited()
    try:
        yield
    finally:
        _unlimited()
        _run.holding = False
    _release()


def _release() -> None:
    """Let go what waits."""
    if _run.waiting:
        _run.waiting = False
        raise KeyboardInterrupt


def _limited() -> None:
    """Begin to count the time in which results must be saved, if that is not done."""
    if _run.limit is None:
        _run.limit = threading.Timer(_SAVING_S, _resend_signal, [_run.came])
        _run.limit.daemon = True
        _run.limit.start()


def _unlimited() -> None:
    if _run.limit is not None:
        _run.limit.cancel()
        _run.limit = None


def _resend_signal(number: int) -> None:
    """In a thread: a signal that counts, which wakes the main thread from a system call."""
    _run.last = -math.inf
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        _thread.interrupt_main(signal.Signals(number))


def _counts() -> bool:
    """Whether the signal that has just come is one of its own."""
    now = time.monotonic()
    before, _run.last = _run.last, now
    return now - before > _TOGETHER_S


def _exit_on_signal(number: int, frame: FrameType | None) -> None:
    if _counts():
        with suppress(OSError):
            os.write(2, b"stereorecal: interrupted\n")
        os._exit(INTERRUPTED)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if not _counts():
        return
    first = not _run.came
    _run.came = _run.came or number
    if first and _run.holding:
        _run.waiting = True
        _limited()
    else:
        raise KeyboardInterrupt


def _reraise_later(unraisable: Any) -> None:
    """In place of printing what a finaliser or a callback has raised: a little later, when they are left."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        threading.Timer(0.01, _resend_signal, [_run.came or signal.SIGTERM]).start()
    else:
        sys.__unraisablehook__(unraisable)
