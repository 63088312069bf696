"""Ranges, distances travelled, or speeds, from tables."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._read_files import about, check_there, read_text
from stereorecal.recordings import Odometer, Range

_ALONG = {"metres": "ray", "depth": "axis"}  # by the name of the column
_OF_RANGES = [f"pair,column,row,{metres}{sigma}" for metres in _ALONG for sigma in (",sigma", "")]
_KINDS = {  # of odometers, by the header
    "time_s,metres": Odometer,
    "time_s,speed_mps": Odometer.from_speeds,
    "time_s,x,y": Odometer.from_positions,
    "time_s,x,y,z": Odometer.from_positions,
}


def load_ranges(path: str | Path) -> tuple[Range, ...]:
    """Ranges from a CSV file with the header `pair,column,row,metres,sigma`: the name of the pair (or its number), the
    pixel of the left image, metres from the camera's centre along the ray (or `inf`), and the standard deviation, which
    may be empty or left out. With the heading `depth` in place of `metres`, distances are along the optical axis.

    Raises:
        InputError: if the file cannot be read, or names the line that makes no sense.
    """
    header, lines = _table(path, _OF_RANGES)
    found = []
    for where, (pair, column, row, metres, *sigma) in lines:
        with about(where):
            pixel, deviation = (_number(column), _number(row)), _number(sigma[0]) if any(sigma) else None
            found.append(Range(pair, pixel, _number(metres), deviation, _ALONG[header.split(",")[3]]))
    if not found:
        raise InputError(f"{path}: the table has no ranges; give at least one.")
    return tuple(found)


def load_odometer(path: str | Path) -> Odometer:
    """The odometer in a CSV file with the header `time_s,metres` (travelled by then), `time_s,speed_mps`, or
    `time_s,x,y,z` (positions in metres, taken as known to 5 cm); times are seconds of the pairs' own clock.

    Raises:
        InputError: if the file cannot be read, or says what makes no sense.
    """
    header, lines = _table(path, [*_KINDS])
    rows = []
    for where, cells in lines:
        with about(where):
            rows.append([_number(cell) for cell in cells])
    times, *columns = np.array(rows, float).reshape(-1, header.count(",") + 1).T
    with about(path):
        return _KINDS[header](times, columns[0] if len(columns) == 1 else np.stack(columns, axis=1))


def _table(path: str | Path, headers: Sequence[str]) -> tuple[str, list[tuple[str, list[str]]]]:
    """The header of a CSV file, one of these, and the cells of each line, "" where the last ones are missing, with what
    messages call the line; empty lines are left out."""
    check_there(Path(path), "add it.")
    text = read_text(Path(path))
    try:
        lines = [[cell.strip() for cell in line] for line in csv.reader(text.splitlines())]
    except csv.Error as error:
        raise InputError(f"{path}: not a table ({error}); write one line for each row.") from None
    (_, first), *others = [(number, line) for number, line in enumerate(lines, 1) if any(line)] or [(1, [""])]
    if ",".join(first) not in headers:
        raise InputError(
            f"{path}: the first line must be {' or '.join(headers)}, divided by commas; write one of these."
        )
    for number, line in others:
        if len(line) > len(first):
            raise InputError(
                f"{path}, line {number}: there are {len(line)} cells under {len(first)} headings; remove some."
            )
    blank = [""] * len(first)
    return ",".join(first), [(f"{path}, line {number}", (line + blank)[: len(first)]) for number, line in others]


def _number(cell: str) -> float:
    """A number as people write it; `inf`, but no overflow and none of Python's underscores."""
    try:
        value = float(cell)
        if "_" in cell or (math.isinf(value) and "inf" not in cell.lower()):
            raise ValueError
    except ValueError:
        raise InputError(f"{cell!r} is no number that can be used; write one such as 12.5.") from None
    return value
