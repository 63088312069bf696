"""Reading files: text read strictly, errors that name the file, and a record of the files that were read."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError

AnyPath = str | os.PathLike[str]
"""A path as users give it."""

_MOST_CHARACTERS = 1 << 26
_GZIP = b"\x1f\x8b"
_files_read: ContextVar[set[Path] | None] = ContextVar("files that were read", default=None)


def check_there(path: Path, advice: str = "check the path.") -> None:
    """Refuse a file that does not exist; what else is wrong with it, a reader says."""
    try:
        path.stat()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; {advice}") from None
    except OSError:
        return


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, without byte order mark; ends of lines are those of the file."""
    note_input(path)
    check_there(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = file.read(_MOST_CHARACTERS + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error
    except UnicodeDecodeError:
        if path.read_bytes()[:2] == _GZIP:
            raise InputError(f"{path}: is compressed; unpack it with gunzip.") from None
        raise InputError(f"{path}: not a text file in UTF-8; copy or write it again.") from None
    if len(text) > _MOST_CHARACTERS:
        raise InputError(
            f"{path}: the text has more than {_MOST_CHARACTERS >> 20} MB; check that this is the right file."
        )
    if not text.strip():
        raise InputError(f"{path}: the file is empty; copy or write it again.")
    return text


def read_bytes(path: AnyPath, most: int = -1) -> bytes:
    """The content of a file, or its first `most` bytes."""
    try:
        with open(path, "rb") as file:
            return file.read(most)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error


@contextmanager
def about(subject: Any) -> Iterator[None]:
    """Prefix the message of any InputError raised inside with `subject`, such as a path, unless that is empty; its
    class is kept."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{subject}: {error}" if subject != "" else f"{error}") from error


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """A set of the real paths of all text and image files that are read inside: output must not replace them."""
    outside = _files_read.get()
    found: set[Path] = set()
    token = _files_read.set(found)
    try:
        yield found
    finally:
        _files_read.reset(token)
        if outside is not None:
            outside |= found


def note_input(path: AnyPath) -> None:
    """Add a file to the enclosing `files_read`."""
    noted = _files_read.get()
    if noted is not None:
        noted.add(Path(os.path.realpath(path)))
