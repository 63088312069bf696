"""Ranges, distances travelled, or speeds, from tables."""

import csv
import math
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._read_files import about, check_there, read_text
from stereorecal.recordings import Odometer, Range

_SIGNS = ";\t|"  # that divide the columns of other tables
_COLUMNS = ("pair", "column", "row", "metres", "sigma")
_ALONG = {"metres": "ray", "depth": "axis"}  # by the name of the column
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
    header, *lines = _lines(path, "one line for each range")
    if len(header) == 1 and any(sign in header[0] for sign in _SIGNS):
        raise InputError(f"{path}: the columns are not divided by commas; write {','.join(_COLUMNS)}.")
    along = _ALONG.get(header[3]) if len(header) > 3 else None
    if along is None or [*header[:3], "metres", *header[4:]] not in ([*_COLUMNS], [*_COLUMNS[:4]]):
        raise InputError(
            f"{path}: the first line is not {','.join(_COLUMNS)} (metres along the ray; call them depth if they are "
            "along the optical axis); write one."
        )
    found = []
    for number, line in enumerate(lines, start=2):
        if not any(line):
            continue
        try:
            pair, *cells = line
            column, row, metres, sigma = (_parsed_number(cell) if cell else math.nan for cell in [*cells, ""][:4])
            if len(line) > len(header):
                raise ValueError(f"there are {len(line)} cells under {len(header)} headings")
            sigma = None if len(cells) < 4 or not cells[3] else sigma
            found.append(Range(pair, (column, row), metres, sigma, along))
        except (ValueError, InputError) as error:
            raise InputError(f"{path}, line {number}: {error}") from None
    if not found:
        raise InputError(f"{path}: the table has no ranges; give at least one.")
    return tuple(found)


def load_odometer(path: str | Path) -> Odometer:
    """The odometer in a CSV file with the header `time_s,metres` (travelled by then), `time_s,speed_mps`, or
    `time_s,x,y,z` (positions in metres, taken as known to 5 cm); times are seconds of the pairs' own clock.

    Raises:
        InputError: if the file cannot be read, or says what makes no sense.
    """
    header, *lines = [line for line in _lines(path, "one line for each time") if any(line)] or [[]]
    with about(path):
        make = _KINDS.get(",".join(header))
        if make is None:
            headers = " or ".join(_KINDS)
            raise InputError(f"the first line is not a header of an odometer file; it must be {headers}.")
        try:
            table = np.array([[float(cell) for cell in line] for line in lines], float).reshape(-1, len(header))
        except ValueError as error:
            raise InputError(
                f"a line does not hold {len(header)} numbers ({error}); write them separated by commas."
            ) from None
        return make(table[:, 0], table[:, 1] if len(header) == 2 else table[:, 1:])


def _parsed_number(cell: str) -> float:
    """A number as people write it; `inf`, but no overflow and none of Python's underscores."""
    try:
        value = float(cell)
        if "_" in cell or (math.isinf(value) and "inf" not in cell.lower()):
            raise ValueError
    except ValueError:
        raise ValueError(f"{cell!r} is no number that can be used; write one such as 12.5") from None
    return value


def _lines(path: str | Path, wanted: str) -> list[list[str]]:
    """The cells of each line of a CSV file, without space around them; there is one line, at least."""
    check_there(Path(path), "add it.")
    text = read_text(Path(path))
    try:
        return [[cell.strip() for cell in line] for line in csv.reader(text.splitlines())]
    except csv.Error as error:
        raise InputError(f"{path}: not a table ({error}); write {wanted}.") from None
