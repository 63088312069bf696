"""The calibration file that a rig was read from, and the prior that was saved with it."""

from dataclasses import dataclass
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, rig_from_data, same_rig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints


@dataclass(frozen=True)
class StoredPrior:
    """A prior as read from a file, not yet checked.

    Attributes:
        place: its name in messages.
        content: None if it cannot be read.
        problem: why it cannot be read.
    """

    place: str
    content: Any
    problem: str | None = None

    def of(self, rig: StereoRig) -> bool:
        """Whether it belongs to a rig.

        Raises:
            InputError: if it cannot be read, or is something else.
        """
        if self.problem is not None:
            raise InputError(self.problem)
        with about(self.place):
            content = self.content if isinstance(self.content, dict) else {}
            return same_rig(rig_from_data(content.get("rig")), rig)


@dataclass(frozen=True)
class RigFile:
    """A calibration file, as needed to write a rig into a copy of it.

    Attributes:
        format: its name.
        documents: the texts, with what they said.
        hints: with which they were read.
        unit: of lengths in the file.
        inferred: whether the unit was inferred from the baseline.
        stored_prior: the prior in the file beside it, as `stored_prior` gives it.
    """

    format: str
    documents: Documents
    hints: Hints
    unit: str
    inferred: bool = False
    stored_prior: StoredPrior | None = None


def file_of(rig: StereoRig) -> RigFile | None:
    """The file that a rig came from, if it came from one."""
    return rig.source if isinstance(rig.source, RigFile) else None
