"""The store of finished rows on the disk: an interrupted run continues where it stopped."""

import os
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal import InputError
from stereorecal.io import json_data, json_line, json_text, make_folder, parse_json, write_text

_SETTINGS, _ROWS, _LOCK = "settings.json", "rows.jsonl", ".lock"


def store_files(folder: Path) -> list[Path]:
    """The files from which a run in this folder continues."""
    return [folder / _SETTINGS, folder / _ROWS]


class Store:
    """A folder that keeps each row as soon as it is there, one line of JSON each. It is this run's own until the
    process ends, however it ends.

    Raises:
        InputError: if the folder holds the rows of other settings or other files, another run works in it, or it cannot
            be written to.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]):
        self._path = folder / _ROWS
        make_folder(folder)
        _refuse_other_files(folder)
        lock = _locked(folder)
        if lock is not None:
            weakref.finalize(self, os.close, lock)
        _agree(folder, json_text(dict(settings), sort_keys=True))
        self.rows = _recovered_rows(self._path)

    def add(self, key: str, row: Mapping[str, Any]) -> dict[str, Any]:
        """Add a row under a new key; returns it as it will be read again."""
        stored = json_data(dict(row))
        line = json_line({"key": key, "row": stored})
        try:
            with open(self._path, "ab") as file:
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:  # what was begun of the line is dropped when the folder is opened again
            raise InputError(
                f"{self._path}: cannot be written ({error.strerror}); make room, and run it again: it continues."
            ) from error
        self.rows[key] = stored
        return stored


def _locked(folder: Path) -> int | None:
    """The descriptor of a file that no other run has locked; None where files cannot be locked."""
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    try:
        file = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written to ({error.strerror}); choose another --output.") from error
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        raise InputError(f"{folder}: another run is working there; wait for it, or choose another --output.") from None
    except OSError:  # a file system without locks
        pass
    return file


def _agree(folder: Path, settings: str) -> None:
    """The settings of a new folder, or the same ones again."""
    path = folder / _SETTINGS
    if not path.exists():
        write_text(path, settings)
    elif path.read_bytes() != settings.encode():
        raise InputError(
            f"{folder}: holds the results of other settings, data or versions; choose another --output, or remove it."
        )


def _refuse_other_files(folder: Path) -> None:
    if not (folder / _SETTINGS).exists() and any(not _left_behind(file) for file in folder.iterdir()):
        raise InputError(
            f"{folder}: holds files that `reproduce` did not write; name a new or empty folder with --output."
        )


def _left_behind(path: Path) -> bool:
    """Whether a file is the lock, or what a run that was killed while writing has left."""
    return path.name == _LOCK or (path.name.startswith(".") and path.suffix == ".tmp")


def _recovered_rows(path: Path) -> dict[str, dict[str, Any]]:
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
