"""The machine as a run may find it: a disk that is full, another run meanwhile, more or fewer cores."""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch


@contextmanager
def at_call(name: str, act: Callable[..., Any], nth: int | None = None) -> Iterator[None]:
    """`act` happens right before the nth call (from 1; None: every call) of os.<name>, which it sees the arguments of
    and may let fail."""
    call, calls = getattr(os, name), []

    def called(*arguments: Any, **options: Any) -> Any:
        calls.append(arguments)
        if nth is None or len(calls) == nth:
            act(*arguments)
        return call(*arguments, **options)

    with patch.object(os, name, called):
        yield


def raising(error: BaseException | type[BaseException]) -> Callable[..., None]:
    """A function that does nothing else."""

    def fail(*_: Any) -> None:
        raise error

    return fail


def full_disk(name: str = "fsync", nth: int | None = None) -> Any:
    """A disk that has no room left: found out when a file is flushed, or where os.<name> is called for the nth time."""
    return at_call(name, raising(OSError(errno.ENOSPC, "No space left on device")), nth)


@contextmanager
def cores(number: int) -> Iterator[None]:
    """As many cores of a CPU, also where a GPU computes."""
    known = hasattr(os, "sched_getaffinity")
    counted = ("os.sched_getaffinity", lambda _: set(range(number))) if known else ("os.cpu_count", lambda: number)
    with patch(*counted), patch("jax.default_backend", lambda: "cpu"):
        yield


def write_protected(name: str) -> Any:
    """Files of this name may not be written, whoever asks: root may write everything."""
    access = os.access
    return patch("os.access", lambda path, mode: os.path.basename(path) != name and access(path, mode))
