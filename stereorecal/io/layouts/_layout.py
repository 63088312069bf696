"""What the module of a layout offers, and what it makes its log of."""

from collections.abc import Hashable, Iterable
from pathlib import Path
from typing import Protocol, runtime_checkable

import jax
import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._scenes import Calibration, fitting
from stereorecal.io.images._image_files import natural_order
from stereorecal.recordings import LazyPairs, Log, Mission


@runtime_checkable
class Layout(Protocol):
    """A module that recognises a folder by what is in it and reads it as a log."""

    @property
    def LAYOUT(self) -> str:
        """Its name and its files, for the message about a folder that no layout recognises: a constant."""
        ...

    def recognises(self, folder: Path) -> bool:
        """Whether the folder has this layout. Looks at names only, and opens no file."""
        ...

    def read(self, folder: Path, limit: int | None) -> Log:
        """The log in the folder, of each sequence the first `limit` pairs or all."""
        ...


Sequence = tuple[Path, StereoRig, LazyPairs]  # its folder, the rig, the pairs
Sides = tuple[str, str]  # of KITTI: the folders of its left and its right camera


def folder_name(folder: Path) -> str:
    """The last two parts of a folder's path, "<parent>/<folder>": the name of a scene or a log."""
    return "/".join(folder.resolve().parts[-2:]).lstrip("/")


def log_of(folder: Path, sequences: Iterable[Sequence]) -> Log:
    """The log of the sequences in a folder, each named after its own folder.

    A single calibration is named "stored"; of several, each is named after the first sequence that has it.

    Raises:
        InputError: if there is no sequence, or the first images of one do not fit its calibration; of others, this is
            said when they are read.
    """
    found: list[tuple[str, Hashable, LazyPairs]] = []
    rigs: dict[Hashable, tuple[str, StereoRig]] = {}
    for place, rig, pairs in sequences:
        name = folder_name(folder) if place == folder else place.name
        rigs.setdefault(_rig_key(rig), (name, rig))
        found.append((name, _rig_key(rig), fitting(place, Calibration(rig.sizes_taken[0], rig), pairs)))
    names = {value: name if len(rigs) > 1 else "stored" for value, (name, _) in rigs.items()}
    calibrations = {names[value]: rig for value, (_, rig) in rigs.items()}
    return Log(
        folder_name(folder), calibrations, tuple(Mission(name, names[value], pairs) for name, value, pairs in found)
    )


def _rig_key(rig: StereoRig) -> Hashable:
    """A key that is equal for equal rigs."""
    leaves, structure = jax.tree.flatten(rig)
    return structure, tuple(np.asarray(leaf).tobytes() for leaf in leaves)


def sequences_in(folder: Path, pattern: str, choices: Iterable[Sides]) -> list[Path]:
    """The folder, if it has images of such cameras, else those below it that have some, in natural order."""
    sides = [side for sides in choices for side in sides]
    places = [place for place in (folder, *folder.glob(pattern)) if any((place / side).is_dir() for side in sides)]
    return [folder] if folder in places else natural_order(places)


def sides_in(folder: Path, choices: Iterable[Sides]) -> Sides:
    """The first choice whose left and right folder both exist."""
    for sides in choices:
        if all((folder / side).is_dir() for side in sides):
            return sides
    wanted = ", or ".join(f"{left} and {right}" for left, right in choices)
    raise InputError(f"{folder}: both cameras are needed, the folders {wanted}; unpack the images of the other one.")
