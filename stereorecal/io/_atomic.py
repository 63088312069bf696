"""Writing files completely or not at all; and copies of files, beside them: NAME.bak."""

import os
import shutil
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._read_files import AnyPath, read_bytes


def write_bytes(path: AnyPath, data: bytes, *, replace: bool = True) -> None:
    """Write `data` to `path`, replacing an existing file only once all data is on the disk.

    An interrupted program leaves the old file or the new one, never a part of it. A path that exists and is not a
    regular file (a pipe, /dev/null) is written to directly.

    Args:
        replace: whether an existing file is replaced; if not, also one that another program makes meanwhile stays.

    Raises:
        InputError: if there is a file that must stay, or the place cannot be written to.
    """
    write_files({Path(path): data}, replace=replace)


def write_text(path: AnyPath, text: str, *, replace: bool = True) -> None:
    """As `write_bytes`, for text, encoded as UTF-8; what it cannot hold, as in names of files, is spelt \\udc80."""
    write_bytes(path, text.encode("utf-8", "backslashreplace"), replace=replace)


def write_files(contents: Mapping[Path, bytes], *, replace: bool = True) -> None:
    """Write files that belong together, each as `write_bytes` does; none is replaced before all are on the disk. An
    InputError names the place that cannot be written to."""
    complete: dict[Path, Path] = {}  # new files, which have no names yet
    try:
        for path, data in contents.items():
            with _as_input_error(path):
                if not replace and os.path.isfile(path):
                    raise FileExistsError
                if path.exists() and not path.is_file():
                    path.write_bytes(data)
                    continue
                final = Path(os.path.realpath(path))  # a link stays one
                complete[path] = final.with_name(f".{uuid.uuid4().hex[:16]}.tmp")  # names may be long already
                with open(complete[path], "xb") as file:
                    file.write(data)
                    file.flush()
                    os.fsync(file.fileno())
                if final.exists():
                    copy_permissions(complete[path], final)
        _give_names(complete, replace)
    finally:
        for temporary in complete.values():
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def _give_names(complete: Mapping[Path, Path], replace: bool) -> None:
    """Give complete files their names, or, where one cannot have it, leave all as they were."""
    old: dict[Path, bytes | None] = {}
    try:
        for path, temporary in complete.items():
            final = Path(os.path.realpath(path))
            with _as_input_error(path):
                before = final.read_bytes() if replace and final.exists() else None
                (os.replace if replace else _rename_exclusively)(temporary, final)
            old[final] = before
    except BaseException:
        for final, before in old.items():
            with suppress(OSError):
                final.unlink() if before is None else final.write_bytes(before)
        raise


def _rename_exclusively(temporary: Path, final: Path) -> None:
    """As `os.replace`, but a file that another program made meanwhile stays, where the file system has links."""
    try:
        os.link(temporary, final)
    except OSError as error:
        if isinstance(error, FileExistsError) or final.is_file():
            raise FileExistsError from error
        os.replace(temporary, final)


def make_folder(path: Path) -> None:
    """Make a folder and its parents, if they do not exist; InputError if that cannot be."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot become a folder ({error.strerror}); choose another.") from error


def copy_permissions(path: Path, model: Path) -> None:
    """Give a file the permissions of another and, where that is allowed, its owner."""
    about = model.stat()
    if hasattr(os, "chown"):
        with suppress(OSError):
            os.chown(path, about.st_uid, about.st_gid)
    shutil.copymode(model, path)


@contextmanager
def _as_input_error(path: Path) -> Iterator[None]:
    """Around the writing of a file: an OSError becomes a sentence."""
    try:
        yield
    except FileExistsError:
        raise InputError(
            f"{path}: the file exists already; choose another name, or say overwrite=True (--force)."
        ) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another place or make room.") from error


def back_up(path: AnyPath) -> Path:
    """Copy a file to `next_copy`; InputError if it cannot be read, or there is no room."""
    copy = next_copy(path)
    write_bytes(copy, read_bytes(path), replace=False)
    copy_permissions(copy, Path(path))
    return copy


def next_copy(path: AnyPath) -> Path:
    """Where a copy of a file is kept: beside what a link leads to, as NAME.bak, or, as no earlier copy is replaced,
    NAME.bak2 and so on."""
    path = Path(path).resolve() if Path(path).is_symlink() else Path(path)
    names = (path.with_name(f"{path.name}.bak{number if number > 1 else ''}") for number in count(1))
    return next(name for name in names if not os.path.lexists(name))
