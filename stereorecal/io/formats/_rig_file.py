"""The calibration file that a rig was read from."""

from dataclasses import dataclass

from stereorecal.geometry import StereoRig
from stereorecal.io.formats._format import Documents, Hints
from stereorecal.io.formats._prior_content import StoredPrior


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
