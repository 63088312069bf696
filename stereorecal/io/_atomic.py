"""Writing files completely or not at all."""

import os
import shutil
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from stereorecal._errors import InputError


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write `data` to `path`, replacing an existing file only once all data is on the disk.

    An interrupted program leaves the old file or the new one, never a part of it. A path that exists and is not a
    regular file (a pipe, /dev/null) is written to directly.

    Raises:
        InputError: if the place cannot be written to.
    """
    write_files({Path(path): data})


def write_files(contents: Mapping[Path, bytes]) -> None:
    """Write files that belong together, each as `write_bytes` does; none is replaced before all are on the disk.

    Raises:
        InputError: naming the place that cannot be written to; all files are as they were.
    """
    replaced: list[tuple[Path, bytes | None]] = []
    waiting: dict[Path, tuple[Path, Path]] = {}  # by place: the complete new file, and where it goes
    try:
        for path, data in contents.items():
            with _said(path):
                if path.exists() and not path.is_file():
                    path.write_bytes(data)
                else:
                    waiting[path] = _beside(_followed(path), data)
        for path, (temporary, final) in waiting.items():
            with _said(path):
                old = final.read_bytes() if final.exists() else None
                os.replace(temporary, final)
                replaced.append((final, old))
    except InputError:
        for final, old in replaced:
            with suppress(OSError):
                _put_back(final, old)
        raise
    finally:
        for temporary, _ in waiting.values():
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def _put_back(path: Path, old: bytes | None) -> None:
    """What was there before a file was replaced."""
    if old is None:
        path.unlink()
    else:
        os.replace(*_beside(path, old))


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


@contextmanager
def _said(path: Path) -> Iterator[None]:
    """Around the writing of a file: an OSError becomes a sentence."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place or make room.") from error


def _followed(path: Path) -> Path:
    """Where a link leads, so that it stays a link; OSError where it leads to itself."""
    with suppress(FileNotFoundError):
        os.stat(path)
    return path.resolve()


def _beside(path: Path, data: bytes) -> tuple[Path, Path]:
    """A complete file beside `path`, which can take its place, and `path`."""
    temporary = path.with_name(f".{path.name[:200]}.{uuid.uuid4().hex[:8]}.tmp")
    try:
        with open(temporary, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return temporary, path
