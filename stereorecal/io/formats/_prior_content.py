"""The content of a saved prior, as a file has it."""

from dataclasses import dataclass
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, rig_from_data, same_rig
from stereorecal.io._read_files import about


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
