"""What the module of a layout offers, and what it makes its log of."""

from collections.abc import Hashable, Iterable
from pathlib import Path
from typing import Protocol, runtime_checkable

import jax
import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.io._scenes import Calibration, fitting
from stereorecal.recordings import LazyPairs, Log, Mission


@runtime_checkable
class Layout(Protocol):
    """A module, or an object, that recognises a folder by what is in it and reads it as a log."""

    @property
    def LAYOUT(self) -> str:
        """Its name and its files, for the message about a folder that no layout recognises: a constant."""
        ...

    def recognises(self, folder: Path, /) -> bool:
        """Whether the folder has this layout. Looks at names only, and opens no file."""
        ...

    def read(self, folder: Path, limit: int | None, /) -> Log:
        """The log in the folder, of each sequence the first `limit` pairs or all."""
        ...


Sequence = tuple[Path, StereoRig, LazyPairs]  # its folder, the rig, the pairs


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
