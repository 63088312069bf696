"""Copies of files, beside them: NAME.bak."""

import os
from itertools import count
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._atomic import copy_permissions, write_bytes
from stereorecal.io._read_files import AnyPath


def back_up(path: AnyPath) -> Path:
    """Copy a file to `next_copy`.

    Raises:
        InputError: if it cannot be read, or there is no room.
    """
    copy = next_copy(path)
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error
    write_bytes(copy, data, replace=False)
    copy_permissions(copy, Path(path))
    return copy


def next_copy(path: AnyPath) -> Path:
    """Where a copy of a file is kept: beside what a link leads to, as NAME.bak, or, as no earlier copy is replaced,
    NAME.bak2 and so on."""
    path = Path(path).resolve() if Path(path).is_symlink() else Path(path)
    names = (path.with_name(f"{path.name}.bak{number if number > 1 else ''}") for number in count(1))
    return next(name for name in names if not os.path.lexists(name))
