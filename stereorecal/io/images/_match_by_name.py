"""Left and right image files matched by their names: by what tells the frame in them, not by what all names of one
camera have in common."""

import re
import warnings
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError, PairingWarning
from stereorecal.io.images._image_files import images_in

Matched = Sequence[tuple[Path, Path]]  # the left and the right file of each pair
_Keys = dict[Hashable, Path]  # files by what tells their frame
_Sides = tuple[_Keys, _Keys]

# What may distinguish the name of a left image from that of its partner, where the words of names vary.
_MARKERS = (("left", "right"), ("Left", "Right"), ("L", "R"), ("l", "r"), ("0", "1"))
# A number, or a word, which ends where capitals begin: LeftImage7 has three parts.
_PARTS = re.compile(r"[0-9]+|[A-Z]?[a-z]+|[A-Z]+|[^\W\d_]+")
_WHOLE = re.compile(r"(?:^|[^A-Za-z0-9])[0-9]+\.$")  # and no cam1.
_FEW = 3  # names that a message mentions
_HOW = "give both images of a pair the same number, or a tolerance if the names are times"


@dataclass(frozen=True)
class MatchedFiles:
    """The files of both sides, matched."""

    matched: Matched  # the files of each pair, in the order of the left ones
    unmatched: tuple[Path, ...] = ()  # those without partner, left ones first
    by_order: bool = False  # whether the files were matched by their order, since no names corresponded


def find_partners(left: Sequence[Path], right: Sequence[Path]) -> MatchedFiles:
    """The files that belong together by their names; those that one camera lost are unmatched. If no name has a
    partner, files are matched in the order given, with a warning."""
    lefts, rights = _by_name(left, right)
    matched = [(path, rights[key]) for key, path in lefts.items() if key in rights]
    if not matched:
        return MatchedFiles(_in_order(left, right), by_order=len(left) > 1)
    unmatched = [lefts[key] for key in lefts if key not in rights]
    unmatched += [rights[key] for key in rights if key not in lefts]
    if not _correspond(lefts, rights):  # equal by chance, it seems
        side = "right" if unmatched[0] in lefts.values() else "left"
        raise InputError(
            f"{unmatched[0]}: this image has no partner on the {side} side, and only {len(matched)} have one of "
            f"{_found(left, right)}; {_HOW}."
        )
    return MatchedFiles(matched, tuple(unmatched))


def without_lost_frames(found: MatchedFiles) -> Matched:
    """The files of pairs."""
    if found.unmatched:
        number, few = len(found.unmatched), ", ".join(map(str, found.unmatched[:_FEW]))
        warnings.warn(
            f"{number} of {number + 2 * len(found.matched)} images have no partner in the other camera and are left "
            f"out: {few}{', …' if number > _FEW else ''}.",
            PairingWarning,
            stacklevel=3,
        )
    return found.matched


def match_all(left: Sequence[Path], right: Sequence[Path]) -> Matched:
    """The files of both sides as pairs, in the order of the left ones, matched by their names."""
    lefts, rights = _by_name(left, right)
    return match_keys(lefts or dict(enumerate(left)), rights)


def match_equal(left: Path, right: Path) -> Matched:
    """The images of two folders whose names without suffix are equal."""
    return match_keys(by_stem(left), by_stem(right))


def match_keys(left: Mapping[Any, Path], right: Mapping[Any, Path]) -> Matched:
    """The files with equal keys, in the order of the left ones; an InputError names a file without a partner."""
    for files, others, side in ((left, right, "right"), (right, left, "left")):
        for path in (path for key, path in files.items() if key not in others):
            raise InputError(f"{path}: this image has no partner on the {side} side; add the partner or leave it out.")
    return [(path, right[key]) for key, path in left.items()]


def by_stem(folder: Path) -> dict[str, Path]:
    """The images of a folder by their names without suffix, in natural order; InputError if there is none."""
    files = {path.stem: path for path in images_in(folder)}
    if not files:
        raise InputError(f"{folder}: there is no such folder, or no image in it; copy or unpack the images.")
    return files


def _by_name(left: Sequence[Path], right: Sequence[Path]) -> _Sides:
    """Both sides by what a name has in common with its partner's: the first reading under which most have one, else
    the first under which any has; empty if none has."""
    by_chance: _Sides = {}, {}
    for read in (_by_stem, _by_parts, _by_markers, _by_one_number):
        sides = read(left, right)
        if _correspond(*sides):
            return sides
        if sides[0].keys() & sides[1].keys():
            by_chance = by_chance if by_chance[0] else sides
    return by_chance


def _by_markers(left: Sequence[Path], right: Sequence[Path]) -> _Sides:
    """Both sides by the first markers without which any names correspond; empty if there are none."""
    found = (
        (_without(left, one, last), _without(right, other, last)) for last in (False, True) for one, other in _MARKERS
    )
    return next((sides for sides in found if sides[0].keys() & sides[1].keys()), ({}, {}))


def _without(files: Sequence[Path], marker: str, last: bool) -> _Keys:
    """Files by names without a marker where it stands first, or last; none where a name lacks it."""
    cut = [path.stem.rpartition(marker) if last else path.stem.partition(marker) for path in files]
    return _unique([start + end for start, _, end in cut], files) if all(given for _, given, _ in cut) else {}


def _by_stem(left: Sequence[Path], right: Sequence[Path]) -> _Sides:
    """Both sides by their names."""
    return _unique([path.stem for path in left], left), _unique([path.stem for path in right], right)


def _unique(keys: Sequence[Hashable], files: Sequence[Path]) -> _Keys:
    """Files by their keys; none if two have the same."""
    return dict(zip(keys, files, strict=True)) if len(set(keys)) == len(files) else {}


def _in_order(left: Sequence[Path], right: Sequence[Path]) -> Matched:
    """The files in order; a single file on each side is unambiguous, and needs no warning."""
    if len(left) != len(right):
        shorter = min(len(left), len(right))
        path = left[shorter] if len(left) > shorter else right[shorter]
        raise InputError(f"{path}: names of {_found(left, right)} have nothing in common that pairs them; {_HOW}.")
    if len(left) > 1:
        warnings.warn(
            f"{left[0]}: no name on the left has a partner on the right, so {len(left)} pairs are made in the order of "
            f"the names, this one with {right[0].name}; check that none is missing, or give a tolerance if the names "
            "are times.",
            PairingWarning,
            stacklevel=2,
        )
    return list(zip(left, right, strict=True))


def _found(left: Sequence[Path], right: Sequence[Path]) -> str:
    return " and ".join(
        f"{len(files)} {side} images ({files[0].name}{f' to {files[-1].name}' if len(files) > 1 else ''})"
        for files, side in ((left, "left"), (right, "right"))
    )


def _by_parts(left: Sequence[Path], right: Sequence[Path]) -> _Sides:
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
        if any(columns) and _correspond(*sides):
            return sides
    return {}, {}


def _by_one_number(left: Sequence[Path], right: Sequence[Path]) -> _Sides:
    """Both sides by one number of their names, such as that of the frame before a time; empty if few correspond."""
    rows = [[[part for part in row if not isinstance(part, str)] for row in _rows(side)] for side in (left, right)]
    places = [range(-least, least) for least in (min(map(len, side)) for side in rows)]
    every = [_keyed(left, rows[0], [place]) for place in places[0]]
    others = [_keyed(right, rows[1], [place]) for place in places[1]]
    found = [sides for sides in product(every, others) if _correspond(*sides)]
    most = max((_partners(sides) for sides in found), key=len, default={})
    for sides in found:
        partners = _partners(sides)
        if len(partners) == len(most) and partners != most:
            path = next(path for path in left if partners.get(path) != most.get(path))
            one, other = (found[path].name if path in found else "missing" for found in (most, partners))
            raise InputError(
                f"{path}: by one number in the names its partner is {one}, by another {other}; leave only the number "
                "of the frame in the names."
            )
    return next((sides for sides in found if _partners(sides) == most), ({}, {}))


def _correspond(left: _Keys, right: _Keys) -> bool:
    """Whether at least half of the files of a side have a partner."""
    return 2 * len(left.keys() & right.keys()) >= min(len(left), len(right)) > 0


def _partners(sides: _Sides) -> dict[Path, Path]:
    return {path: sides[1][key] for key, path in sides[0].items() if key in sides[1]}


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


def _keyed(files: Sequence[Path], rows: Sequence[Sequence[Hashable]], columns: Sequence[int]) -> _Keys:
    """The files by what stands in these columns; none if that is not unique."""
    return _unique([tuple(row[column] for column in columns) for row in rows], files)
