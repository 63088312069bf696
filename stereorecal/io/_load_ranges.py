"""Ranges from a table."""

import csv
import math
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._read_files import read_text
from stereorecal.recordings import Range

_SIGNS = ";\t|"  # that divide the columns of other tables
_COLUMNS = ("pair", "column", "row", "metres", "sigma")
_ALONG = {"metres": "ray", "depth": "axis"}  # by the name of the column


def load_ranges(path: str | Path) -> tuple[Range, ...]:
    """Ranges from a CSV file with the header `pair,column,row,metres,sigma`: the name of the pair (or its number), the
    pixel of the left image, metres from the camera's centre along the ray (or `inf`), and the standard deviation, which
    may be empty or left out. With the heading `depth` in place of `metres`, distances are along the optical axis.

    Raises:
        InputError: if the file cannot be read, or names the line that makes no sense.
    """
    text = read_text(Path(path))
    try:
        lines = list(csv.reader(text.splitlines()))
    except csv.Error as error:
        raise InputError(f"{path}: not a table ({error}); write one line for each range.") from None
    header = [name.strip() for name in lines[0]] if lines else []
    if len(header) == 1 and any(sign in header[0] for sign in _SIGNS):
        raise InputError(f"{path}: the columns are not divided by commas; write {','.join(_COLUMNS)}.")
    along = _ALONG.get(header[3]) if len(header) > 3 else None
    if along is None or [*header[:3], "metres", *header[4:]] not in ([*_COLUMNS], [*_COLUMNS[:4]]):
        raise InputError(
            f"{path}: the first line is not {','.join(_COLUMNS)} (metres along the ray; call them depth if they are "
            "along the optical axis); write one."
        )
    found = []
    for number, line in enumerate(lines[1:], start=2):
        if not any(cell.strip() for cell in line):
            continue
        try:
            pair, *cells = (cell.strip() for cell in line)
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


def _parsed_number(cell: str) -> float:
    """A number as people write it; `inf`, but no overflow and none of Python's underscores."""
    try:
        value = float(cell)
        if "_" in cell or (math.isinf(value) and "inf" not in cell.lower()):
            raise ValueError
    except ValueError:
        raise ValueError(f"{cell!r} is no number that can be used; write one such as 12.5") from None
    return value
