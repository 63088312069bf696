"""OpenCV's FileStorage files: YAML, XML or JSON with matrices in them."""

import math
from pathlib import Path
from typing import Any

import cv2

from stereorecal._errors import InputError
from stereorecal.io._text import read_text

# OpenCV's parser calls itself at each level of nesting and crashes the process near 100 000 levels. Nesting is no
# deeper than there are opening brackets and tags, or items begun on one line, or than indentation fits into the text.
_MOST_OPENINGS = 2000
_LONGEST = 1 << 20  # characters, room for 1 400 levels of indentation; a calibration of a rig has a few thousand
_SATURATED = 2**63  # OpenCV clips integers to 64 bit


def read_file_storage(path: Path) -> dict[str, Any]:
    """The content of a file as plain values; a map of rows, cols and data becomes a list of rows.

    OpenCV reads ordinary YAML as well, as far as sensor.yaml files need it, with or without the line %YAML:1.0. It
    reads true and false as 1 and 0.

    Raises:
        InputError: naming the file, if it is missing, or OpenCV cannot read it.
    """
    text = read_text(path)
    if not _is_flat(text):
        raise InputError(f"{path}: too long or too deeply nested for a calibration; check that this is the right file.")
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        content = _plain(storage.root())
    except (cv2.error, SystemError, RecursionError):  # the constructor's errors come as SystemError
        content = None
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a YAML file as OpenCV writes it, or truncated; correct or copy it again.")
    return content


def _is_flat(text: str) -> bool:
    """Whether a text is one that OpenCV's parser can be given."""
    openings = sum(text.count(bracket) for bracket in "[{<")
    items = max(line.count("- ") for line in text.splitlines())
    return len(text) <= _LONGEST and openings <= _MOST_OPENINGS and items <= _MOST_OPENINGS


def _plain(node: Any) -> Any:
    if node.isMap():
        return _rows({key: _plain(node.getNode(key)) for key in node.keys()})  # noqa: SIM118 (a node is no mapping)
    if node.isSeq():
        return [_plain(node.at(index)) for index in range(node.size())]
    if node.isString():
        return node.string()
    if node.isInt():
        return int(node.real()) if abs(node.real()) < _SATURATED else math.copysign(math.inf, node.real())
    return node.real() if node.isReal() else None


def _rows(content: dict[str, Any]) -> Any:
    match content:
        case {"rows": int(rows), "cols": int(columns), "data": list(data)} if columns > 0:
            # If the numbers do not fill the matrix they stay a flat list, and the reader says what it expected.
            fits = rows * columns == len(data)
            return [data[start : start + columns] for start in range(0, len(data), columns)] if fits else data
        case _:
            return content
