"""Binary files of named arrays, as values that a JSON file could hold: NumPy's .npz and .npy, and MATLAB's files of
version 5 (save -v6, -v7), of which SciPy's reader ends the process where some of them are damaged."""

import io
import math
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._read_files import about, note_input, read_bytes
from stereorecal.io._strict_json import strict_json_text

_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_DOUBLE, _MATRIX, _COMPRESSED = 9, 14, 15
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, _OPAQUE = 1, 2, 3, 4, 5, 17
_UNPACKED = 1 << 26  # bytes of a variable once it is unpacked
_DEEPEST = 12  # structs within structs
_OBJECTS = (
    "it holds objects that only MATLAB reads; in MATLAB write s = toStruct(stereoParams) and save('calib.mat', 's', "
    "'-v7'), or the text of jsonencode(toStruct(stereoParams)) to a .json file."
)


def variables(data: bytes) -> dict[str, Any]:
    """The variables of a file by their names: arrays of float64, texts, dicts of structs, lists of cells."""
    reader = _Reader("<" if data[126:128] == b"IM" else ">")
    found: dict[str, Any] = {}
    for kind, content in reader.elements(data[128:]):
        packed = kind == _COMPRESSED
        inside = reader.elements(zlib.decompressobj().decompress(content, _UNPACKED)) if packed else [(kind, content)]
        found |= dict(reader.matrix(part, 0) for of_kind, part in inside if of_kind == _MATRIX)
    return found


@dataclass(frozen=True)
class _Reader:
    """`<` or `>`, the order of bytes."""

    order: str

    def elements(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """The type and the content of each element."""
        at = 0
        while at + 8 <= len(data):
            kind, size = (int(number) for number in np.frombuffer(data, f"{self.order}u4", 2, at))
            start = at + 8
            if kind >> 16:  # a small one, in the place of its size
                kind, size, start = kind & 0xFFFF, kind >> 16, at + 4
                if size > 4:
                    raise ValueError("a small element of more than four bytes")
            if start + size > len(data):
                raise ValueError("an element that is longer than the file")
            yield kind, data[start : start + size]
            at = start + size if kind == _COMPRESSED else start + size + -(start + size - at) % 8

    def matrix(self, data: bytes, depth: int) -> tuple[str, Any]:
        """The name and the value of a variable, or of a field or cell, which has no name."""
        if depth > _DEEPEST:
            raise ValueError("nested too deeply")
        if not data:
            return "", np.zeros((0, 0))
        parts = self.elements(data)
        flags = self._numbers(*next(parts))
        kind = int(flags[0]) & 0xFF
        if kind in (_OPAQUE, _OBJECT):
            raise InputError(_OBJECTS)
        shape = [int(side) for side in self._numbers(*next(parts))]
        name = next(parts)[1].decode("latin-1")
        if kind == _STRUCT:
            return name, self._structs(parts, math.prod(shape), depth)
        if kind == _CELL:
            return name, [self.matrix(content, depth + 1)[1] for _, content in parts]
        if kind == _SPARSE:
            return name, None
        part, content = next(parts, (_DOUBLE, b""))
        if kind == _CHAR:
            utf = _TEXTS[part]
            ending = "" if utf in ("latin-1", "utf-8") else "-le" if self.order == "<" else "-be"
            return name, content.decode(utf + ending)
        return name, self._numbers(part, content).astype(float).reshape(shape, order="F")

    def _structs(self, parts: Iterator[tuple[int, bytes]], count: int, depth: int) -> Any:
        """One struct, or a list of them."""
        length = int(self._numbers(*next(parts))[0])
        joined = next(parts)[1].decode("latin-1")
        names = [joined[at : at + length].rstrip("\0") for at in range(0, len(joined), max(length, 1))]
        values = [self.matrix(content, depth + 1)[1] for _, content in parts]
        if len(values) != count * len(names):
            raise ValueError("fields are missing")
        each = range(0, len(values), max(len(names), 1))
        found = [dict(zip(names, values[at : at + len(names)], strict=True)) for at in each]
        return found[0] if len(found) == 1 else found

    def _numbers(self, kind: int, content: bytes) -> np.ndarray:
        return np.frombuffer(content, self.order + _NUMBERS[kind])


_LARGEST = 1 << 24  # bytes of a file
_MOST = 1000  # numbers of an array: a matrix of a camera has few, and images and maps are not needed
_DAMAGED = "cannot be read, or truncated; copy or write it again."


def binary_text(path: Path) -> str | None:
    """The content of a binary file as JSON, which is never executed; None if it is no such file."""
    try:
        data = read_bytes(path, _LARGEST + 1)
    except InputError:
        return None  # said by the reader of texts
    with about(path):
        reader = _reader(data)
        if reader is None:
            return None
        note_input(path)
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


def _reader(data: bytes) -> Callable[[bytes, str], dict[str, Any]] | None:
    if data.startswith(b"PK\x03\x04"):
        return _npz
    if data.startswith(b"\x93NUMPY"):
        return lambda data, stem: {stem: _small(np.load(io.BytesIO(data), allow_pickle=False))}
    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InputError("an HDF5 file, as of MATLAB's save with -v7.3; save it with '-v7', or as JSON (jsonencode).")
    if data.startswith(b"MATLAB 5.0"):
        return lambda data, _: {name: _small(value) for name, value in variables(data).items()}
    if data.startswith((b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05")):
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
