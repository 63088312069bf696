"""Backup copies of a calibration file, beside it: NAME.bak, NAME.bak2 and so on."""

import os
import re
from contextlib import suppress
from itertools import count
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._atomic import FileTaken, copy_permissions, write_bytes
from stereorecal.io._read_files import AnyPath


def back_up(path: AnyPath) -> Path:
    """Copy a file beside itself, as NAME.bak, or NAME.bak2 and so on: no earlier copy is replaced.

    Raises:
        InputError: if it cannot be read, or there is no room.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error
    while True:
        copy = next_copy(path)
        with suppress(FileTaken):  # by another run in the meantime
            write_bytes(copy, data, replace=False)
            copy_permissions(copy, path)
            return copy


def next_copy(path: AnyPath) -> Path:
    """Where `back_up` will copy a file to: beside what a link leads to."""
    path = _without_link(path)
    names = (path.with_name(f"{path.name}.bak{number if number > 1 else ''}") for number in count(1))
    return next(name for name in names if not os.path.lexists(name))


def is_copy(path: AnyPath, of: AnyPath) -> bool:
    """Whether a path is where `back_up` has copied, or may copy, a file to."""
    path, of = Path(path).resolve(), _without_link(of)
    return path.parent == of.parent.resolve() and re.fullmatch(rf"{re.escape(of.name)}\.bak\d*", path.name) is not None


def _without_link(path: AnyPath) -> Path:
    return Path(path).resolve() if Path(path).is_symlink() else Path(path)
