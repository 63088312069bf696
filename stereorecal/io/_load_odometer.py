"""Distances travelled, or speeds, from a table."""

import csv
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._read_files import read_text
from stereorecal.recordings import Odometer

_KINDS = (("time_s", "metres"), ("time_s", "speed_mps"), ("time_s", "x", "y"), ("time_s", "x", "y", "z"))


def load_odometer(path: str | Path) -> Odometer:
    """From a CSV file whose header is `time_s,metres` (travelled by then), `time_s,speed_mps`, or `time_s,x,y,z`
    (positions in metres, taken as known to 5 cm); times are seconds of the pairs' own clock.

    Raises:
        InputError: if the file cannot be read, or says what makes no sense.
    """
    text = read_text(Path(path))
    try:
        lines = [line for line in csv.reader(text.splitlines()) if any(cell.strip() for cell in line)]
    except csv.Error as error:
        raise InputError(f"{path}: not a table ({error}); write one line for each time.") from None
    header = tuple(name.strip() for name in lines[0]) if lines else ()
    if header not in _KINDS:
        headers = " or ".join(",".join(names) for names in _KINDS)
        raise InputError(f"{path}: the first line is not a header of an odometer file; it must be {headers}.")
    try:
        table = np.array([[float(cell) for cell in line] for line in lines[1:]], float).reshape(-1, len(header))
    except ValueError as error:
        raise InputError(
            f"{path}: a line does not hold {len(header)} numbers ({error}); write them separated by commas."
        ) from None
    try:
        if header == _KINDS[0]:
            return Odometer(table[:, 0], table[:, 1])
        if header == _KINDS[1]:
            return Odometer.from_speeds(table[:, 0], table[:, 1])
        return Odometer.from_positions(table[:, 0], table[:, 1:])
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
