"""Files that options name: calibrations, which are one file, a folder, a data set, or LEFT,RIGHT; and places to write
to, all checked before the work. Nothing here takes time to import.
"""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereorecal._errors import InputError, check_exists

CalibrationPath = Path | tuple[Path, Path]


def calibration_path(words: str | Sequence[str], option: str) -> CalibrationPath:
    """The path, or the paths of the left and the right camera's file: two words, or one with a comma."""
    words = [words] if isinstance(words, str) else list(words)
    if len(words) == 1 and "," in words[0] and not Path(words[0]).exists():
        words = words[0].split(",")
    if not all(words):
        raise InputError(f"{option} is empty; give the name of a file or folder.")
    if len(words) > 2:
        raise InputError(f"{option} takes one file, or two where each camera has its own; {len(words)} were given.")
    return Path(words[0]) if len(words) == 1 else (Path(words[0]), Path(words[1]))


def paths(where: CalibrationPath | str) -> list[Path]:
    """One or two paths."""
    return list(where) if isinstance(where, tuple) else [Path(where)]


def check_calibration(words: str | Sequence[str], option: str) -> None:
    """Refuse files that are not there."""
    for path in paths(calibration_path(words, option)):
        check_exists(path, "file")


@dataclass(frozen=True)
class Place:
    """A file that an option names."""

    option: str
    path: Path

    def __str__(self) -> str:
        return f"{self.option} {self.path}"


def check_places(places: Sequence[Place], *, force: bool) -> None:
    """Refuse, before anything is read, what could not be written.

    Args:
        force: whether existing files may be replaced; a pipe or a device is written to in any case.

    Raises:
        InputError: if a file exists, two have one place, or a place cannot be written to.
    """
    by_identity: dict[object, Place] = {}
    for place in places:
        check_writable(place)
        if place.path.exists() and not place.path.is_file():
            continue
        if place.path.exists() and not force:
            raise InputError(f"{place}: the file exists already; choose another or add --force.")
        other = by_identity.setdefault(_identity(place.path), place)
        if other is not place:
            raise InputError(f"{other.option} and {place.option} name the same file; give two.")


def check_writable(place: Place) -> None:
    """Refuse a place that cannot be written to."""
    path, usable = place.path, True
    try:
        found = os.stat(path)
    except FileNotFoundError:
        found = None
    except OSError as error:
        raise InputError(f"{place}: cannot be written there ({error.strerror}); choose another.") from None
    if found is not None:
        usable = not path.is_dir() and os.access(path, os.W_OK)
    if found is None or path.is_file():  # a file is replaced by a new one, which its folder must take
        folder = path.resolve().parent
        usable = usable and folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)
    if not usable:
        raise InputError(f"{place}: cannot be written there; give a file in an existing folder, or allow writing.")


def refuse_replacing_inputs(
    places: Iterable[Place], inputs: Iterable[Path], instead: str = "choose another place"
) -> None:
    """Refuse to replace what was read, whatever is forced.

    Raises:
        InputError: naming the option.
    """
    read = {_identity(path) for path in inputs}
    for place in places:
        if _identity(place.path) in read:
            raise InputError(f"{place}: this is an input file of the run and will not be overwritten; {instead}.")


def named_inputs(*words: str | Path | Sequence[str] | None) -> list[Path]:
    """The files among what people gave to be read, such as "left.png" or "left.yaml,right.yaml"."""
    every = [word for some in words for word in (some if isinstance(some, list | tuple) else [some])]
    parts = [part for word in every if word is not None for part in (str(word), *str(word).split(","))]
    return [Path(part) for part in parts if part]


def _identity(path: Path) -> object:
    """What all names of a file have in common, hard links too; of one that does not exist, where it would be."""
    try:
        found = os.stat(path)
    except OSError:
        return path.resolve()
    return found.st_dev, found.st_ino
