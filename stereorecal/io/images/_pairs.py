"""Image pairs from files."""

import glob
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io.images._files import images_in, natural_order, read_image
from stereorecal.recordings import Pair, make_pair

AnyPath = str | os.PathLike[str]

# What may tell the name of a left image from that of its partner.
_MARKERS = (("", ""), ("left", "right"), ("Left", "Right"), ("L", "R"), ("l", "r"), ("0", "1"))


def load_pair(left_path: AnyPath, right_path: AnyPath) -> Pair:
    """One pair from two image files: grey or colour, 8 or 16 bit, any format OpenCV reads.

    The pair is named after the left file, and is pickled as its two absolute paths.

    Raises:
        InputError: if a file is missing, empty, truncated or no image, if the two images differ in size or
            bit depth, or if one is constant.
    """
    left, right = os.path.abspath(left_path), os.path.abspath(right_path)
    if left == right:
        raise InputError(f"{left}: this file is both the left and the right image; give two files.")
    pair = make_pair(
        read_image(left),
        read_image(right),
        channels="bgr",
        name=f"{left} and {right}",  # what errors are about
        origin=(load_pair, (left, right)),
    )
    return replace(pair, name=Path(left).name)


def load_pairs(left: AnyPath, right: AnyPath, limit: int | None = None) -> tuple[Pair, ...]:
    """Pairs from two sets of image files, each a glob pattern, a folder or one file.

    Files whose names are equal, or equal but for left/right, L/R or 0/1, belong together. Where no name has
    a partner, files are matched in natural order (9 before 10).

    Args:
        limit: read the first `limit` pairs only.

    Raises:
        InputError: if nothing matches, an image has no partner, or a file is bad (see `load_pair`).
    """
    matched = match_files(_find(left), _find(right))
    return tuple(load_pair(*paths) for paths in first(matched, limit))


def first(matched: Sequence[tuple[Path, Path]], limit: int | None) -> Sequence[tuple[Path, Path]]:
    """The first `limit` pairs of files, or all."""
    if limit is not None and limit < 1:
        raise InputError(f"the limit of {limit} pairs leaves none; give 1 or more.")
    return matched[:limit]


def match_files(left: Sequence[Path], right: Sequence[Path], *, by_order: bool = True) -> list[tuple[Path, Path]]:
    """The files of both sides as pairs, in the order of the left ones, matched as `load_pairs` says.

    Args:
        by_order: whether files without any names in common are matched in the order given.

    Raises:
        InputError: naming a file without partner.
    """
    for markers in _MARKERS:
        by_key_left, by_key_right = (_by_key(files, m) for files, m in zip((left, right), markers, strict=True))
        if not by_key_left.keys() & by_key_right.keys():
            continue
        for key, path in (by_key_left | by_key_right).items():
            if key not in by_key_left or key not in by_key_right:
                raise alone(path, "right" if key in by_key_left else "left")
        return [(path, by_key_right[key]) for key, path in by_key_left.items()]
    if len(left) != len(right) or not by_order:
        shorter = min(len(left), len(right)) if by_order else 0
        raise alone(*((left[shorter], "right") if len(left) > shorter else (right[shorter], "left")))
    return list(zip(left, right, strict=True))


def _by_key(files: Sequence[Path], marker: str) -> dict[str, Path]:
    """Files by their name without `marker`; none if the names do not tell them apart."""
    by_key = {path.stem.replace(marker, "", 1): path for path in files if marker in path.stem}
    return by_key if len(by_key) == len(files) else {}


def alone(path: Path, side: str) -> InputError:
    """The error about an image whose partner on a side is missing."""
    return InputError(f"{path}: this image has no partner on the {side} side; add the partner or leave it out.")


def _find(where: AnyPath) -> list[Path]:
    path = Path(where)
    if path.is_file():
        return [path]
    found = images_in(path) or natural_order(Path(name) for name in glob.glob(str(where), recursive=True))
    found = [path for path in found if path.is_file()]
    if not found:
        raise InputError(
            f"{where}: no image matches; give a file, a folder of images or a pattern such as 'left/*.png'."
        )
    return found
