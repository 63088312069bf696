"""Calibration files as people name them on the command line: one file, a folder, a data set, or LEFT,RIGHT."""

from collections.abc import Sequence
from pathlib import Path

from stereorecal._errors import InputError, check_exists

CalibrationPath = Path | tuple[Path, Path]


def calibration_path(words: str | Sequence[str], option: str) -> CalibrationPath:
    """The path, or the paths of the left and the right camera's file: two words, or one with a comma.

    Raises:
        InputError: if there are more.
    """
    words = [words] if isinstance(words, str) else list(words)
    if len(words) == 1 and "," in words[0] and not Path(words[0]).exists():
        words = words[0].split(",")
    if not all(words):
        raise InputError(f"{option} is empty; give the name of a file or folder.")
    if len(words) > 2:
        raise InputError(f"{option} takes one file, or two where each camera has its own; {len(words)} were given.")
    return Path(words[0]) if len(words) == 1 else (Path(words[0]), Path(words[1]))


def paths(where: CalibrationPath) -> list[Path]:
    """One or two paths."""
    return list(where) if isinstance(where, tuple) else [where]


def check_calibration(words: str | Sequence[str], option: str) -> None:
    """Refuse files that are not there.

    Raises:
        InputError: names the first.
    """
    for path in paths(calibration_path(words, option)):
        check_exists(path, "file")
