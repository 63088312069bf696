"""Writing a file completely or not at all."""

import os
import uuid
from pathlib import Path

from stereorecal._errors import InputError


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write `data` to `path`, replacing an existing file only once all data is on the disk.

    An interrupted program leaves the old file or the new one, never a part of it. A path that exists and is not a
    regular file (a pipe, /dev/null) is written to directly.

    Raises:
        InputError: if the place cannot be written to.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)
        else:
            _replace(path.resolve(), data)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place or make room.") from error


def make_folder(path: Path) -> None:
    """Make a folder and its parents, if they do not exist.

    Raises:
        InputError: if the folder cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot become a folder ({error.strerror}); choose another.") from error


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """As `write_bytes`, for text, encoded as UTF-8."""
    write_bytes(path, text.encode("utf-8"))


def _replace(path: Path, data: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.tmp")
    try:
        with open(temporary, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
