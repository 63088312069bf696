"""Binary files of named arrays, as values that a JSON file could hold: NumPy's .npz and .npy, MATLAB's .mat."""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._read_files import about, note_input
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats.text._mat_file import variables

_LARGEST = 1 << 24  # bytes of a file
_MOST = 1000  # numbers of an array: a matrix of a camera has few, and images and maps are not needed
_DAMAGED = "cannot be read, or truncated; copy or write it again."


def binary_text(path: Path) -> str | None:
    """The content of a binary file as JSON, which is never executed; None if it is no such file.

    Raises:
        InputError: naming the file, if it is of such a kind, but cannot be read.
    """
    try:
        with path.open("rb") as file:
            head = file.read(128)
            with about(path):
                reader = _reader(head)
            data = head + file.read(_LARGEST + 1 - len(head)) if reader else b""
    except OSError:
        return None  # said by the reader of texts
    if reader is None:
        return None
    note_input(path)
    with about(path):
        if len(data) > _LARGEST:
            raise InputError(f"it has more than {_LARGEST >> 20} MB; check that this is a calibration.")
        try:
            content = reader(data, path.stem)
        except InputError:
            raise
        except Exception:  # damaged files end in errors of many kinds: of zlib, of NumPy, of Python
            raise InputError(_DAMAGED) from None
        try:
            return strict_json_text(content)
        except (ValueError, TypeError, RecursionError):
            raise InputError("it contains NaN or infinite numbers, or nests too deeply; correct it.") from None


def _reader(head: bytes) -> Callable[[bytes, str], dict[str, Any]] | None:
    if head.startswith(b"PK\x03\x04"):
        return _npz
    if head.startswith(b"\x93NUMPY"):
        return lambda data, stem: {stem: _small(np.load(io.BytesIO(data), allow_pickle=False))}
    if head.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InputError("an HDF5 file, as of MATLAB's save with -v7.3; save it with '-v7', or as JSON (jsonencode).")
    if head.startswith(b"MATLAB 5.0"):
        return lambda data, _: {name: _small(value) for name, value in variables(data).items()}
    if head.startswith((b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05")):
        raise InputError("a pickle, which is not opened, since it can run code; write the arrays with np.savez.")
    return None


def _npz(data: bytes, _: str) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        found = {}
        for info in archive.infolist():
            if info.filename.endswith(".npy") and info.file_size <= 1024 + 16 * _MOST:
                raw = io.BytesIO(archive.read(info))
                try:
                    found[info.filename.removesuffix(".npy")] = _small(np.load(raw, allow_pickle=False))
                except ValueError:  # objects, such as lists of boards' corners
                    continue
        if not found:
            raise InputError("there are no arrays of a camera in it; check that this is the right file.")
        return found


def _small(value: Any, depth: int = 0) -> Any:
    """A value as JSON has it; None for what no camera needs."""
    match value:
        case dict() if depth < 6:
            return {str(key): _small(inside, depth + 1) for key, inside in value.items()}
        case np.ndarray() if value.dtype.kind in "iufb" and value.size <= _MOST:
            return value.tolist()
        case list() if depth < 6:
            return [_small(inside, depth + 1) for inside in value]
        case str():
            return value
    return None
