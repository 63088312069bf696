"""Rows that are finished, on the disk: an interrupted run continues where it stopped."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal._plain import plain
from stereorecal.io import make_folder, write_text

_SETTINGS, _ROWS = "settings.json", "rows.jsonl"


class Store:
    """A folder that keeps each row as soon as it is there, one line of JSON each.

    Raises:
        InputError: if the folder holds the rows of other settings, or cannot be written to.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]):
        make_folder(folder)
        self._path = folder / _ROWS
        _agree(folder, json.dumps(plain(dict(settings)), indent=1, sort_keys=True, allow_nan=False) + "\n")
        self.rows = _read(self._path)

    def add(self, key: str, row: Mapping[str, Any]) -> dict[str, Any]:
        """Keep a row under a key that is new; returns it as it will be read again."""
        kept = plain(dict(row))
        line = json.dumps({"key": key, "row": kept}, allow_nan=False) + "\n"
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self.rows[key] = kept
        return kept


def _agree(folder: Path, settings: str) -> None:
    """The settings of a new folder, or the same ones again."""
    path = folder / _SETTINGS
    if not path.exists():
        write_text(path, settings)
    elif path.read_text(encoding="utf-8") != settings:
        raise InputError(
            f"{folder}: holds the results of other settings, data or versions; choose another --output, or remove it."
        )


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """The rows of whole lines; a line that was cut off while it was written is dropped from the file."""
    if not path.exists():
        return {}
    lines = path.read_text(encoding="utf-8").split("\n")
    if lines[-1]:
        write_text(path, "".join(f"{line}\n" for line in lines[:-1]))
    found = [json.loads(line) for line in lines[:-1]]
    return {entry["key"]: entry["row"] for entry in found}
