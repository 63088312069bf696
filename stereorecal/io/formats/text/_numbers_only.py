"""Texts that have no keys: lines of numbers, and the ost.txt that ROS' camera_calibration writes beside its YAML."""

import re
from typing import Any, NoReturn

from stereorecal._errors import InputError
from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Values

_SECTION = re.compile(r"\[(.+)\]")


def numbers_in(text: str) -> list[list[float]] | None:
    """The numbers of each line; None if there is anything else but comments."""
    rows = []
    for line in text.splitlines():
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        row = [number for word in words if isinstance(number := number_or_word(word), float)]
        if len(row) < len(words):
            return None
        rows += [row] if row else []
    return rows or None


def parsed_numbers(text: str) -> dict[str, Any]:
    """The lines of numbers, under the key `numbers`."""
    found = numbers_in(text) or []
    return {"numbers": [x for row in found for x in row] if len(found) == 1 else found}


def parsed_sections(text: str) -> dict[str, Any]:
    """The values of an ost.txt by section and title: a title stands on a line of its own, and its numbers below.

    Raises:
        InputError: if a section occurs twice with different numbers.
    """
    sections: list[tuple[str, dict[str, Any]]] = []
    title = ""
    for line in (line.partition("#")[0].strip() for line in text.splitlines()):
        section, row = _SECTION.fullmatch(line), numbers_in(line)
        if section:
            sections.append((section[1], {}))
        elif row is None:
            title = line or title
        elif sections:
            sections[-1][1].setdefault(title, []).extend(row)
    return without_duplicates([(name, {key: _plain(rows) for key, rows in held.items()}) for name, held in sections])


def _plain(rows: list[list[float]]) -> Any:
    return rows if len(rows) > 1 else rows[0] if len(rows[0]) > 1 else rows[0][0]


def unchangeable(text: str, values: Values) -> NoReturn:
    """Refuse to write into such a text.

    Raises:
        InputError: always.
    """
    raise InputError("a text without keys is read, not written; write a new file, such as calib.json.")
