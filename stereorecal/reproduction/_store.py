"""Rows that are finished, on the disk: an interrupted run continues where it stopped."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal._plain import plain
from stereorecal.io import json_line, json_text, make_folder, parse_json, write_text

_SETTINGS, _ROWS = "settings.json", "rows.jsonl"


class Store:
    """A folder that keeps each row as soon as it is there, one line of JSON each.

    Raises:
        InputError: if the folder holds the rows of other settings or other files, or cannot be written to.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]):
        self._path = folder / _ROWS
        _agree(folder, json_text(dict(settings), sort_keys=True))
        self.rows = _read(self._path)

    def add(self, key: str, row: Mapping[str, Any]) -> dict[str, Any]:
        """Keep a row under a key that is new; returns it as it will be read again."""
        kept = plain(dict(row))
        line = json_line({"key": key, "row": kept})
        with open(self._path, "ab", buffering=0) as file:  # one write: lines of two runs never mix
            file.write(line.encode())
            os.fsync(file.fileno())
        self.rows[key] = kept
        return kept


def _agree(folder: Path, settings: str) -> None:
    """The settings of a new folder, or the same ones again."""
    make_folder(folder)
    path = folder / _SETTINGS
    if not path.exists():
        if any(folder.iterdir()):
            raise InputError(f"{folder}: holds other files; choose a new folder for the results with --output.")
        write_text(path, settings)
    elif path.read_bytes() != settings.encode():
        raise InputError(
            f"{folder}: holds the results of other settings, data or versions; choose another --output, or remove it."
        )


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """The rows of whole lines. A line that was cut off or damaged is dropped from the file: its task is done again."""
    if not path.exists():
        return {}
    lines = path.read_bytes().split(b"\n")
    found = [entry for line in lines if (entry := _entry(line)) is not None]
    if len(found) < len(lines) - 1 or lines[-1]:
        write_text(path, "".join(json_line(entry) for entry in found))
    return {entry["key"]: entry["row"] for entry in found}


def _entry(line: bytes) -> dict[str, Any] | None:
    try:
        entry = parse_json(line.decode())
    except ValueError:  # InputError, or no UTF-8
        return None
    whole = isinstance(entry, dict) and isinstance(entry.get("key"), str) and isinstance(entry.get("row"), dict)
    return entry if whole else None
