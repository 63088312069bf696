"""OpenCV's FileStorage files: YAML, XML or JSON with matrices in them."""

from pathlib import Path
from typing import Any

import cv2

from stereorecal._errors import InputError
from stereorecal.io.formats._text import read_text


def read_file_storage(path: Path) -> dict[str, Any]:
    """What the file says as plain values; a map of rows, cols and data becomes a list of rows.

    OpenCV reads ordinary YAML as well, as far as sensor.yaml files need it, with or without the line %YAML:1.0.

    Raises:
        InputError: if the file is missing, or is none that OpenCV can read.
    """
    text = read_text(path)
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        content = _plain(storage.root())
    except (cv2.error, SystemError):  # the constructor's errors come as the latter
        content = None
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a YAML file as OpenCV writes it, or truncated; correct or copy it again.")
    return content


def _plain(node: Any) -> Any:
    if node.isMap():
        return _rows({key: _plain(node.getNode(key)) for key in node.keys()})  # noqa: SIM118 (a node is no mapping)
    if node.isSeq():
        return [_plain(node.at(index)) for index in range(node.size())]
    if node.isString():
        return node.string()
    if node.isInt():
        return int(node.real())
    return node.real() if node.isReal() else None


def _rows(content: dict[str, Any]) -> Any:
    match content:
        case {"rows": int(rows), "cols": int(columns), "data": list(data)} if columns > 0:
            # Left as it is where the numbers do not fill it: what it should be, the reader knows.
            whole = rows * columns == len(data)
            return [data[start : start + columns] for start in range(0, len(data), columns)] if whole else data
        case _:
            return content
