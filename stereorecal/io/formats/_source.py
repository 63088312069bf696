"""The file that a rig came from."""

from dataclasses import dataclass
from typing import Any

from stereorecal.geometry import StereoRig
from stereorecal.io.formats._format import Documents, Hints


@dataclass(frozen=True)
class Source:
    """What is needed to write a rig into a copy of its file.

    Attributes:
        format: its name.
        documents: the texts, with what they said.
        hints: with which they were read.
        unit: of lengths in the file.
        inferred: whether nobody said the unit.
        beside: what the file beside it says of how well it is known, as `stored_prior` gives it.
    """

    format: str
    documents: Documents
    hints: Hints
    unit: str
    inferred: bool = False
    beside: Any = None  # a Stored, whose module imports this one


def source_of(rig: StereoRig) -> Source | None:
    """The file that a rig came from, if it came from one."""
    return rig.source if isinstance(rig.source, Source) else None
