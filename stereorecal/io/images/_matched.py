"""The frames of a sequence: files that belong together by their names, read as pairs."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io.images._files import images_in
from stereorecal.io.images._pairs import alone, first, load_pair
from stereorecal.recordings import Pair

Matched = Sequence[tuple[Path, Path]]


def load_matched(matched: Matched, limit: int | None) -> tuple[Pair, ...]:
    """The first `limit` pairs, or all.

    Raises:
        InputError: if a file is bad (see `load_pair`), or the limit leaves none.
    """
    return tuple(load_pair(*files) for files in first(matched, limit))


def match_equal(left: Path, right: Path) -> Matched:
    """The images of two folders whose names are equal but for the suffix.

    Raises:
        InputError: if a folder has none, or an image has no partner.
    """
    return match_keys(by_stem(left), by_stem(right))


def match_marked(folder: Path) -> Matched:
    """The images NAMEL.* and NAMER.* of one folder.

    Raises:
        InputError: if there is none, or one has no partner.
    """
    files = by_stem(folder)
    left, right = ({stem[:-1]: path for stem, path in files.items() if stem.endswith(mark)} for mark in "LR")
    if not (left or right):
        raise InputError(
            f"{folder}: no image in there has a name that ends in L or R, such as 00000001L.jpg; add some."
        )
    return match_keys(left, right)


def by_stem(folder: Path) -> dict[str, Path]:
    """The images of a folder by their names without suffix, in natural order.

    Raises:
        InputError: if there is none.
    """
    files = {path.stem: path for path in images_in(folder)}
    if not files:
        raise InputError(f"{folder}: there is no such folder, or no image in it; copy or unpack the images.")
    return files


def match_keys(left: Mapping[str, Path], right: Mapping[str, Path]) -> Matched:
    """The files of equal keys, in the order of the left ones.

    Raises:
        InputError: naming a file without partner.
    """
    for files, others, side in ((left, right, "right"), (right, left, "left")):
        for key, path in files.items():
            if key not in others:
                raise alone(path, side)
    return [(path, right[key]) for key, path in left.items()]
