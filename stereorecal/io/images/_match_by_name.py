"""Left and right image files matched by their names."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from stereorecal._errors import InputError, PairingWarning
from stereorecal.io.images._image_files import images_in

Matched = Sequence[tuple[Path, Path]]  # the left and the right file of each pair

# What may distinguish the name of a left image from that of its partner.
_MARKERS = (("", ""), ("left", "right"), ("Left", "Right"), ("L", "R"), ("l", "r"), ("0", "1"))


@dataclass(frozen=True)
class MatchedFiles:
    """The files of both sides, matched.

    Attributes:
        matched: the files of each pair, in the order of the left ones.
        unmatched: those without partner, left ones first.
        by_order: whether the files were matched by their order, since no names corresponded.
    """

    matched: Matched
    unmatched: tuple[Path, ...] = ()
    by_order: bool = False


def find_partners(left: Sequence[Path], right: Sequence[Path]) -> MatchedFiles:
    """The files that belong together by their names; those that one camera lost are unmatched. If no name has a
    partner, files are matched in the order given.

    Raises:
        InputError: naming a file without a partner, if most have none.

    Warns:
        PairingWarning: if files were matched by their order.
    """
    lefts, rights = _by_name(left, right)
    matched = [(path, rights[key]) for key, path in lefts.items() if key in rights]
    if not matched:
        return MatchedFiles(_in_order(left, right), by_order=len(left) > 1)
    if 2 * len(matched) < min(len(left), len(right)):  # equal by chance, it seems
        match_keys(lefts, rights)
    unmatched = [
        path for files, others in ((lefts, rights), (rights, lefts)) for key, path in files.items() if key not in others
    ]
    return MatchedFiles(matched, tuple(unmatched))


def match_files(left: Sequence[Path], right: Sequence[Path], *, by_order: bool = True) -> Matched:
    """The files of both sides as pairs, in the order of the left ones, matched as `load_pairs` says.

    Args:
        by_order: whether files are matched in the order given if no name has a partner.

    Raises:
        InputError: naming a file without a partner.

    Warns:
        PairingWarning: as `find_partners`.
    """
    lefts, rights = _by_name(left, right)
    if lefts:
        return match_keys(lefts, rights)
    if not by_order:
        raise _no_partner(left[0], "right")
    return _in_order(left, right)


def match_equal(left: Path, right: Path) -> Matched:
    """The images of two folders whose names without suffix are equal.

    Raises:
        InputError: if a folder has no image, or naming an image without a partner.
    """
    return match_keys(by_stem(left), by_stem(right))


def match_marked(folder: Path) -> Matched:
    """The images NAMEL.* and NAMER.* of one folder.

    Raises:
        InputError: if there is none, or naming an image without a partner.
    """
    files = by_stem(folder)
    left, right = ({stem[:-1]: path for stem, path in files.items() if stem.endswith(mark)} for mark in "LR")
    if not (left or right):
        raise InputError(
            f"{folder}: no image in there has a name that ends in L or R, such as 00000001L.jpg; add some."
        )
    return match_keys(left, right)


def match_keys(left: Mapping[str, Path], right: Mapping[str, Path]) -> Matched:
    """The files with equal keys, in the order of the left ones.

    Raises:
        InputError: naming a file without a partner.
    """
    for files, others, side in ((left, right, "right"), (right, left, "left")):
        for key, path in files.items():
            if key not in others:
                raise _no_partner(path, side)
    return [(path, right[key]) for key, path in left.items()]


def by_stem(folder: Path) -> dict[str, Path]:
    """The images of a folder by their names without suffix, in natural order.

    Raises:
        InputError: if there is none.
    """
    files = {path.stem: path for path in images_in(folder)}
    if not files:
        raise InputError(f"{folder}: there is no such folder, or no image in it; copy or unpack the images.")
    return files


def _by_name(left: Sequence[Path], right: Sequence[Path]) -> tuple[dict[str, Path], dict[str, Path]]:
    """Both sides by what a name has in common with its partner's; empty if no name has one."""
    for last, markers in product((False, True), _MARKERS):
        lefts, rights = (_by_key(files, m, last) for files, m in zip((left, right), markers, strict=True))
        if lefts.keys() & rights.keys():
            return lefts, rights
    return {}, {}


def _in_order(left: Sequence[Path], right: Sequence[Path]) -> Matched:
    """The files in order; a single file on each side is unambiguous, and needs no warning."""
    if len(left) != len(right):
        shorter = min(len(left), len(right))
        raise _no_partner(*((left[shorter], "right") if len(left) > shorter else (right[shorter], "left")))
    if len(left) > 1:
        warnings.warn(
            f"{left[0]}: no name on the left has a partner on the right, so {len(left)} pairs are made in the order of "
            f"the names, this one with {right[0].name}; check that none is missing, or give a tolerance if the names "
            "are times.",
            PairingWarning,
            stacklevel=2,
        )
    return list(zip(left, right, strict=True))


def _by_key(files: Sequence[Path], marker: str, last: bool) -> dict[str, Path]:
    """Files by their names without `marker` where it stands first, or last; none if those names are not unique."""
    by_key = {}
    for path in files:
        at = path.stem.rfind(marker) if last else path.stem.find(marker)
        if at >= 0:
            by_key[path.stem[:at] + path.stem[at + len(marker) :]] = path
    return by_key if len(by_key) == len(files) else {}


def _no_partner(path: Path, side: str) -> InputError:
    """The error about an image whose partner on a side is missing."""
    return InputError(f"{path}: this image has no partner on the {side} side; add the partner or leave it out.")
