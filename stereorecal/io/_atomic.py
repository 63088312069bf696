"""Writing a file completely or not at all."""

import os
import shutil
import uuid
from collections.abc import Sequence
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


def write_texts(paths: Sequence[Path], texts: Sequence[str]) -> None:
    """Write several files, all or none: what has been replaced is put back if a later one fails.

    Raises:
        InputError: naming the place that cannot be written to.
    """
    whole: list[tuple[Path, Path, Path]] = []  # as given, where it is, and the new content beside it
    replaced: list[tuple[Path, bytes | None]] = []
    path = paths[0]
    try:
        for path, text in zip(paths, texts, strict=True):
            if path.exists() and not path.is_file():
                path.write_text(text, encoding="utf-8")
            else:
                place = path.resolve()
                temporary = _temporary(place)
                whole.append((path, place, temporary))
                _fill(temporary, place, text.encode("utf-8"))
        for each in whole:
            path, place, temporary = each
            replaced.append((place, place.read_bytes() if place.exists() else None))
            os.replace(temporary, place)
    except OSError as error:
        for place, old in replaced:
            if old is None:
                place.unlink(missing_ok=True)
            elif place.read_bytes() != old:
                _replace(place, old)
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place or make room.") from error
    finally:
        for _, _, temporary in whole:
            temporary.unlink(missing_ok=True)


def _replace(path: Path, data: bytes) -> None:
    temporary = _temporary(path)
    try:
        _fill(temporary, path, data)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _temporary(path: Path) -> Path:
    return path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.tmp")


def _fill(temporary: Path, path: Path, data: bytes) -> None:
    """Write what is to replace `path`, with the permissions that it has."""
    with open(temporary, "xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    if path.exists():
        shutil.copymode(path, temporary)
