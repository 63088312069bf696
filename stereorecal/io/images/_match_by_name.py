"""Left and right image files matched by their names: by what tells the frame in them, not by what all names of one
camera have in common."""

import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError, PairingWarning, warn
from stereorecal.io.images._image_files import images_in

Files = Sequence[Path]
Matched = Sequence[tuple[Path, Path]]  # the left and the right file of each pair
_Partners = dict[Path, Path]  # the right file of each left one that has a partner, in the order of the left ones

# What may distinguish the name of a left image from that of its partner, where the words of names vary.
_MARKERS = (("left", "right"), ("Left", "Right"), ("L", "R"), ("l", "r"), ("0", "1"))
# A number, or a word, which ends where capitals begin: LeftImage7 has three parts.
_PARTS = re.compile(r"[0-9]+|[A-Z]?[a-z]+|[A-Z]+|[^\W\d_]+")
_WHOLE = re.compile(r"(?:^|[^A-Za-z0-9])[0-9]+\.$")  # and no cam1.
_HOW = "give both images of a pair the same number, or a tolerance if the names are times"


@dataclass(frozen=True)
class MatchedFiles:
    """The files of both sides, matched."""

    matched: Matched  # the files of each pair, in the order of the left ones
    unmatched: tuple[Path, ...] = ()  # those without partner, left ones first
    by_order: bool = False  # whether the files were matched by their order, since no names corresponded


def find_partners(left: Files, right: Files) -> MatchedFiles:
    """The files that belong together by their names; those that one camera lost are unmatched. If no name has a
    partner, files are matched in the order given, with a warning."""
    partners = _by_name(left, right)
    if not partners:
        return MatchedFiles(_in_order(left, right), by_order=len(left) > 1)
    alone, other_alone = _alone(partners, left, right)
    if not _most(partners, left, right):  # equal by chance, it seems
        side = "right" if alone else "left"
        raise InputError(
            f"{(alone + other_alone)[0]}: this image has no partner on the {side} side, and only {len(partners)} have "
            f"one of {_found(left, right)}; {_HOW}."
        )
    return MatchedFiles([*partners.items()], (*alone, *other_alone))


def match_all(left: Files, right: Files) -> Matched:
    """The files of both sides as pairs, in the order of the left ones, matched by their names."""
    return _complete(_by_name(left, right), left, right)


def match_keys(left: Mapping[Any, Path], right: Mapping[Any, Path]) -> Matched:
    """The files with equal keys, in the order of the left ones; an InputError names a file without a partner."""
    partners = {path: right[key] for key, path in left.items() if key in right}
    return _complete(partners, [*left.values()], [*right.values()])


def _complete(partners: _Partners, left: Files, right: Files) -> Matched:
    """The pairs, where every file has a partner."""
    for side, alone in zip(("right", "left"), _alone(partners, left, right), strict=True):
        if alone:
            raise InputError(
                f"{alone[0]}: this image has no partner on the {side} side; add the partner or leave it out."
            )
    return [*partners.items()]


def by_stem(folder: Path) -> dict[str, Path]:
    """The images of a folder by their names without suffix, in natural order; InputError if there is none."""
    files = {path.stem: path for path in images_in(folder)}
    if not files:
        raise InputError(f"{folder}: there is no such folder, or no image in it; copy or unpack the images.")
    return files


def _alone(partners: _Partners, left: Files, right: Files) -> tuple[list[Path], list[Path]]:
    matched = set(partners.values())
    return [path for path in left if path not in partners], [path for path in right if path not in matched]


def _most(partners: _Partners, left: Files, right: Files) -> bool:
    """Whether at least half of the files of a side have a partner."""
    return 2 * len(partners) >= min(len(left), len(right)) > 0


def _by_name(left: Files, right: Files) -> _Partners:
    """Pairs by what a name has in common with its partner's: the first reading under which most have one, else the
    first under which any has."""
    by_chance: _Partners = {}
    for read in (_by_stem, _by_parts, _by_markers, _by_one_number):
        partners = read(left, right)
        if _most(partners, left, right):
            return partners
        by_chance = by_chance or partners
    return by_chance


def _equal(left: Files, left_keys: Sequence[Hashable], right: Files, right_keys: Sequence[Hashable]) -> _Partners:
    """The files with equal keys; none where two of a side have the same."""
    if len(set(left_keys)) < len(left) or len(set(right_keys)) < len(right):
        return {}
    known = dict(zip(right_keys, right, strict=True))
    return {path: known[key] for path, key in zip(left, left_keys, strict=True) if key in known}


def _by_stem(left: Files, right: Files) -> _Partners:
    return _equal(left, [path.stem for path in left], right, [path.stem for path in right])


def _by_markers(left: Files, right: Files) -> _Partners:
    """Pairs by the first markers without which any names correspond, where they stand first, or else last."""
    for cut, (one, other) in product((str.partition, str.rpartition), _MARKERS):
        lefts, rights = [cut(path.stem, one) for path in left], [cut(path.stem, other) for path in right]
        if all(given for _, given, _ in lefts + rights):
            partners = _equal(left, [a + b for a, _, b in lefts], right, [a + b for a, _, b in rights])
            if partners:
                return partners
    return {}


def _in_order(left: Files, right: Files) -> Matched:
    """The files in order; a single file on each side is unambiguous, and needs no warning."""
    if len(left) != len(right):
        shorter = min(len(left), len(right))
        path = left[shorter] if len(left) > shorter else right[shorter]
        raise InputError(f"{path}: names of {_found(left, right)} have nothing in common that pairs them; {_HOW}.")
    if len(left) > 1:
        warn(
            f"{left[0]}: no name on the left has a partner on the right, so {len(left)} pairs are made in the order of "
            f"the names, this one with {right[0].name}; check that none is missing, or give a tolerance if the names "
            "are times.",
            PairingWarning,
        )
    return list(zip(left, right, strict=True))


def _found(left: Files, right: Files) -> str:
    return " and ".join(
        f"{len(files)} {side} images ({files[0].name}{f' to {files[-1].name}' if len(files) > 1 else ''})"
        for files, side in ((left, "left"), (right, "right"))
    )


def _by_parts(left: Files, right: Files) -> _Partners:
    """Pairs by the parts of names that vary from frame to frame; none if few correspond.

    Where all names have as many parts, those that vary on either side are compared: a camera may have lost all frames
    but one. Else those that vary on their own side.
    """
    rows = [_rows(left), _rows(right)]
    own = [_varying(side) for side in rows]
    either = sorted({*own[0], *own[1]})
    alike = len({len(row) for side in rows for row in side}) == 1
    for columns in ([[either, either]] if alike else []) + [own]:
        lefts, rights = (
            [tuple(row[at] for at in some) for row in side] for side, some in zip(rows, columns, strict=True)
        )
        partners = _equal(left, lefts, right, rights)
        if any(columns) and _most(partners, left, right):
            return partners
    return {}


def _by_one_number(left: Files, right: Files) -> _Partners:
    """Pairs by one number of the names, such as that of the frame before a time; none if few correspond."""
    rows = [[[part for part in row if not isinstance(part, str)] for row in _rows(side)] for side in (left, right)]
    columns = [
        [[row[at] for row in side] for least in [min(map(len, side))] for at in range(-least, least)] for side in rows
    ]
    readings = [_equal(left, one, right, other) for one, other in product(*columns)]
    found = [partners for partners in readings if _most(partners, left, right)]
    most = max(found, key=len, default={})
    for partners in found:
        if len(partners) == len(most) and partners != most:
            path = next(path for path in left if partners.get(path) != most.get(path))
            one, other = (each[path].name if path in each else "missing" for each in (most, partners))
            raise InputError(
                f"{path}: by one number in the names its partner is {one}, by another {other}; leave only the number "
                "of the frame in the names."
            )
    return most


def _rows(files: Files) -> list[list[Hashable]]:
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
