"""Calibration files as people name them on the command line: one file, a folder, or LEFT,RIGHT."""

import re
from collections.abc import Sequence
from pathlib import Path

from stereorecal._errors import InputError

Place = Path | tuple[Path, Path]


def place(words: str | Sequence[str], option: str) -> Place:
    """The path, or the paths of the left and the right camera's file: two words, or one with a comma.

    Raises:
        InputError: if there are more.
    """
    words = [words] if isinstance(words, str) else list(words)
    if len(words) == 1 and "," in words[0] and not Path(words[0]).exists():
        words = words[0].split(",")
    if len(words) > 2:
        raise InputError(f"{option} takes one file, or two where each camera has its own; {len(words)} were given.")
    return Path(words[0]) if len(words) == 1 else (Path(words[0]), Path(words[1]))


def paths(where: Place) -> list[Path]:
    """One or two paths."""
    return list(where) if isinstance(where, tuple) else [where]


def size(text: str | None) -> tuple[int, int] | None:
    """ "640x480" as (width, height).

    Raises:
        InputError: if it is none.
    """
    if text is None:
        return None
    found = re.fullmatch(r"([1-9]\d{0,6})x([1-9]\d{0,6})", text)
    if found is None:
        raise InputError(f"--size is {text!r}; give width and height in pixels, such as 640x480.")
    return int(found[1]), int(found[2])
