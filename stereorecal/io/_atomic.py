"""Writing files completely or not at all."""

import os
import shutil
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from stereorecal._errors import InputError


class FileTaken(InputError):
    """A file exists already, and was not to be replaced."""


def write_bytes(path: str | os.PathLike[str], data: bytes, *, replace: bool = True) -> None:
    """Write `data` to `path`, replacing an existing file only once all data is on the disk.

    An interrupted program leaves the old file or the new one, never a part of it. A path that exists and is not a
    regular file (a pipe, /dev/null) is written to directly.

    Args:
        replace: whether an existing file is replaced; if not, also one that another program makes meanwhile stays.

    Raises:
        InputError: if there is a file that must stay, or the place cannot be written to.
    """
    write_files({Path(path): data}, replace=replace)


def write_files(contents: Mapping[Path, bytes], *, replace: bool = True) -> None:
    """Write files that belong together, each as `write_bytes` does; none is replaced before all are on the disk.

    Raises:
        InputError: naming the place that cannot be written to; all files are as they were.
    """
    for path in () if replace else contents:
        if os.path.isfile(path):
            raise _taken(path)
    written: list[tuple[Path, bytes | None]] = []
    waiting: dict[Path, tuple[Path, Path]] = {}  # by place: the complete new file, and where it goes
    try:
        for path, data in contents.items():
            with _as_input_error(path):
                if path.exists() and not path.is_file():
                    path.write_bytes(data)
                else:
                    waiting[path] = _complete_copy(_link_target(path), data)
        for path, (temporary, final) in waiting.items():
            with _as_input_error(path):
                old = final.read_bytes() if replace and final.exists() else None
                (os.replace if replace else _rename_exclusively)(temporary, final)
                written.append((final, old))
    except BaseException:
        for final, old in written:
            with suppress(OSError):
                _put_back(final, old)
        raise
    finally:
        for temporary, _ in waiting.values():
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def copy_permissions(path: Path, model: Path) -> None:
    """Give a file the permissions of another and, where that is allowed, its owner."""
    about = model.stat()
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(path, about.st_uid, about.st_gid)
    shutil.copymode(model, path)


def _rename_exclusively(temporary: Path, final: Path) -> None:
    """Give a complete file its name; FileExistsError if somebody else has it."""
    try:
        os.link(temporary, final)
    except FileExistsError:
        raise
    except OSError:  # a file system without links: the name is taken first
        with open(final, "xb"):
            pass
        os.replace(temporary, final)


def _put_back(path: Path, old: bytes | None) -> None:
    """Restore a file that was replaced."""
    if old is None:
        path.unlink()
    else:
        os.replace(*_complete_copy(path, old))


def make_folder(path: Path) -> None:
    """Make a folder and its parents, if they do not exist.

    Raises:
        InputError: if the folder cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot become a folder ({error.strerror}); choose another.") from error


def write_text(path: str | os.PathLike[str], text: str, *, replace: bool = True) -> None:
    """As `write_bytes`, for text, encoded as UTF-8; what it cannot hold, as in names of files, is spelt \\udc80."""
    write_bytes(path, text.encode("utf-8", "backslashreplace"), replace=replace)


@contextmanager
def _as_input_error(path: Path) -> Iterator[None]:
    """Around the writing of a file: an OSError becomes a sentence."""
    try:
        yield
    except FileExistsError:
        raise _taken(path) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place or make room.") from error


def _taken(path: Path) -> FileTaken:
    return FileTaken(f"{path}: the file exists already; choose another name, or say overwrite=True (--force).")


def _link_target(path: Path) -> Path:
    """Where a link leads, so that it stays a link; OSError where it leads to itself."""
    with suppress(FileNotFoundError):
        os.stat(path)
    return path.resolve()


def _complete_copy(path: Path, data: bytes) -> tuple[Path, Path]:
    """A complete temporary file in the folder of `path`, ready to replace it, and `path`."""
    temporary = path.with_name(f".{uuid.uuid4().hex[:16]}.tmp")  # short: `path` may be as long as names can be
    try:
        with open(temporary, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            copy_permissions(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return temporary, path
