"""Which files have been read: they must not be replaced by what is made of them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_noted: ContextVar[set[Path] | None] = ContextVar("files that are read", default=None)


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """A set that every text and image file joins that is read inside, with its real path."""
    outside = _noted.get()
    found: set[Path] = set()
    token = _noted.set(found)
    try:
        yield found
    finally:
        _noted.reset(token)
        if outside is not None:
            outside |= found


def note_input(path: str | os.PathLike[str]) -> None:
    """Say that a file is read."""
    noted = _noted.get()
    if noted is not None:
        noted.add(Path(os.path.realpath(path)))
