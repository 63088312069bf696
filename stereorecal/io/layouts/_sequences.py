"""A log of sequences that each come with a calibration: those with equal ones share it."""

from collections.abc import Hashable, Iterable
from pathlib import Path

import jax
import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.io._about import about
from stereorecal.io.layouts._scene_folder import name_of
from stereorecal.recordings import Log, Mission, Pair, check_pairs

Sequence = tuple[Path, StereoRig, tuple[Pair, ...]]  # where it lies, what took it, what it took


def log_of(folder: Path, sequences: Iterable[Sequence]) -> Log:
    """The log of the sequences in a folder, each named after its own place.

    The calibration is named "stored" if there is one only, else after the first sequence that it holds for.

    Raises:
        InputError: if there is no sequence, or one does not fit its calibration.
    """
    found: list[tuple[str, Hashable, tuple[Pair, ...]]] = []
    rigs: dict[Hashable, tuple[str, StereoRig]] = {}
    for place, rig, pairs in sequences:
        with about(place):  # the log checks too, but cannot say where the images lie
            check_pairs(rig, pairs)
        name = name_of(folder) if place == folder else place.name
        rigs.setdefault(_value(rig), (name, rig))
        found.append((name, _value(rig), pairs))
    names = {value: name if len(rigs) > 1 else "stored" for value, (name, _) in rigs.items()}
    calibrations = {names[value]: rig for value, (_, rig) in rigs.items()}
    return Log(name_of(folder), calibrations, tuple(Mission(name, names[value], pairs) for name, value, pairs in found))


def _value(rig: StereoRig) -> Hashable:
    """What is equal for equal rigs."""
    leaves, structure = jax.tree.flatten(rig)
    return structure, tuple(np.asarray(leaf).tobytes() for leaf in leaves)
