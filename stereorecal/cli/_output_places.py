"""The places that a command writes to, all checked before the work; nothing here takes time to import."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli._options import CommonOptions
from stereorecal.cli._shared_options import ImageOptions


@dataclass(frozen=True)
class Place:
    """A file that an option names."""

    option: str
    path: Path

    def __str__(self) -> str:
        return f"{self.option} {self.path}"


def places_of(options: CommonOptions, *names: str) -> list[Place]:
    """The files that these options name; stdout ("-") is none."""
    named = [(f"--{name}", getattr(options, name, None)) for name in names]
    return [Place(option, Path(text)) for option, text in named if text is not None and text != "-"]


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
    """Refuse a place that cannot be written to.

    Raises:
        InputError: says why.
    """
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


def image_inputs(options: ImageOptions) -> list[Path]:
    """The images, videos and bags that are named by themselves, and may be read only later."""
    return named_inputs(options.left, options.right, options.side_by_side, options.bag)


def _identity(path: Path) -> object:
    """What all names of a file have in common, hard links too; of one that does not exist, where it would be."""
    try:
        found = os.stat(path)
    except OSError:
        return path.resolve()
    return found.st_dev, found.st_ino
