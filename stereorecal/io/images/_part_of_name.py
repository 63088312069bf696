"""Which part of the names of images tells the frame: not what all names of one camera have in common."""

import re
from collections.abc import Hashable, Iterator, Sequence
from itertools import product
from pathlib import Path

from stereorecal._errors import InputError

Keys = dict[Hashable, Path]  # files by what tells their frame
Sides = tuple[Keys, Keys]

# A number, or a word, which ends where capitals begin: LeftImage7 has three parts.
_PARTS = re.compile(r"[0-9]+|[A-Z]?[a-z]+|[A-Z]+|[^\W\d_]+")
_WHOLE = re.compile(r"(?:^|[^A-Za-z0-9])[0-9]+\.$")  # and no cam1.


def by_parts(left: Sequence[Path], right: Sequence[Path]) -> Sides:
    """Both sides by the parts of their names that vary from frame to frame; empty if few correspond.

    Where all names have as many parts, those that vary on either side are compared: a camera may have lost all frames
    but one. Else those that vary on their own side.
    """
    rows = [_rows(left), _rows(right)]
    varying = [_varying(side) for side in rows]
    either = sorted({*varying[0], *varying[1]})
    alike = len({len(row) for side in rows for row in side}) == 1
    for columns in ([[either, either]] if alike else []) + [varying]:
        sides = _keyed(left, rows[0], columns[0]), _keyed(right, rows[1], columns[1])
        if any(columns) and correspond(*sides):
            return sides
    return {}, {}


def by_one_number(left: Sequence[Path], right: Sequence[Path]) -> Sides:
    """Both sides by one number of their names, such as that of the frame before a time; empty if few correspond.

    Raises:
        InputError: if two numbers pair equally many images, and pair them otherwise.
    """
    rows = [[[part for part in row if not isinstance(part, str)] for row in _rows(side)] for side in (left, right)]
    places = [range(-least, least) for least in (min(map(len, side)) for side in rows)]
    every = [_keyed(left, rows[0], [place]) for place in places[0]]
    others = [_keyed(right, rows[1], [place]) for place in places[1]]
    found = [sides for sides in product(every, others) if correspond(*sides)]
    most = max((_partners(sides) for sides in found), key=len, default={})
    for sides in found:
        partners = _partners(sides)
        if len(partners) == len(most) and partners != most:
            path = next(path for path in left if partners.get(path) != most.get(path))
            raise InputError(
                f"{path}: by one number in the names its partner is {_name(most.get(path))}, by another "
                f"{_name(partners.get(path))}; leave only the number of the frame in the names."
            )
    return next((sides for sides in found if _partners(sides) == most), ({}, {}))


def correspond(left: Keys, right: Keys) -> bool:
    """Whether at least half of the files of a side have a partner."""
    return 2 * len(left.keys() & right.keys()) >= min(len(left), len(right)) > 0


def _partners(sides: Sides) -> dict[Path, Path]:
    return {path: sides[1][key] for key, path in sides[0].items() if key in sides[1]}


def _name(path: Path | None) -> str:
    return "missing" if path is None else path.name


def _rows(files: Sequence[Path]) -> list[list[Hashable]]:
    """The parts of each name, or of the whole path where only folders tell files apart."""
    unique = len({path.stem for path in files}) == len(files)
    return [list(_parts(path.stem if unique else str(path.with_suffix("")))) for path in files]


def _parts(text: str) -> Iterator[Hashable]:
    for found in _PARTS.finditer(text):
        part, start = found[0], found.start()
        if not part.isdecimal():
            yield part
        elif _WHOLE.search(text[:start]):
            yield ("fraction", part)  # .5 is not .05
        else:
            yield int(part)


def _varying(rows: Sequence[Sequence[Hashable]]) -> list[int]:
    """The columns that are not constant; none where names have different numbers of parts."""
    columns = zip(*rows, strict=False) if len(set(map(len, rows))) == 1 else ()
    return [number for number, column in enumerate(columns) if len(set(column)) > 1]


def _keyed(files: Sequence[Path], rows: Sequence[Sequence[Hashable]], columns: Sequence[int]) -> Keys:
    """The files by what stands in these columns; none if that is not unique."""
    keys: Keys = {tuple(row[column] for column in columns): path for row, path in zip(rows, files, strict=True)}
    return keys if len(keys) == len(files) else {}
