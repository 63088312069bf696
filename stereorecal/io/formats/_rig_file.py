"""The calibration file that a rig was read from; and the saved prior of a calibration, a key of a calib.json, or a file
beside a calibration of any other format.

The content of a prior is that of `SavedPrior.as_dict`; here it is JSON data, of which only the rig is read.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, rig_from_data, same_rig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import read_json
from stereorecal.io.formats._format import Documents, Hints
from stereorecal.io.formats._stereorecal import NAME
from stereorecal.io.formats.text._document import Syntax, document
from stereorecal.io.formats.text._nodes import at

KEY = "prior"
ENDING = ".prior.json"


@dataclass(frozen=True)
class StoredPrior:
    """A prior as read from a file, not yet checked."""

    place: str  # its name in messages
    content: Any  # None if it cannot be read
    problem: str | None = None  # why it cannot be read

    def of(self, rig: StereoRig) -> bool:
        """Whether it belongs to a rig."""
        return self.read(lambda content: same_rig(rig_from_data(at(content, ("rig",))), rig))

    def read(self, reader: Callable[[Any], Any]) -> Any:
        """The content as a reader has it."""
        if self.problem is not None:
            raise InputError(self.problem)
        with about(self.place):
            return reader(self.content)


@dataclass(frozen=True)
class RigFile:
    """A calibration file, as needed to write a rig into a copy of it."""

    format: str  # its name
    documents: Documents  # the texts, with what they said
    hints: Hints  # with which they were read
    unit: str  # of lengths in the file
    inferred: bool = False  # whether the unit was inferred from the baseline
    beside: StoredPrior | None = None  # the prior in the file beside it

    @property
    def prior(self) -> StoredPrior | None:
        """The prior that was saved with it, in the file or beside it; None if there is none."""
        if self.format != NAME:
            return self.beside
        content = self.documents[0].content.get(KEY)
        return None if content is None else StoredPrior(f"{self.documents[0].name}, {KEY!r}", content)


def file_of(rig: StereoRig | None) -> RigFile | None:
    """The file that a rig came from, if there is a rig and it came from one."""
    return rig.source if rig is not None and isinstance(rig.source, RigFile) else None


def prior_file(path: Path) -> Path:
    """The file beside a calibration, beside what a link leads to."""
    path = path.resolve() if path.is_symlink() else path
    return path.with_name(path.name + ENDING)


def read_stored_prior(path: Path) -> StoredPrior | None:
    """The file beside a calibration, if there is one."""
    place = prior_file(path)
    if not os.path.isfile(place):  # False, too, where the name is too long
        return None
    try:
        return StoredPrior(str(place), read_json(place))
    except InputError as error:
        return StoredPrior(str(place), None, str(error))


def own_prior(rig: StereoRig) -> dict[str, Any] | None:
    """The stored prior of a rig that is unchanged since it was read; None if there is none."""
    source = file_of(rig)
    stored = None if source is None else source.prior
    return stored.content if stored is not None and stored.of(rig) else None


def prior_place(paths: Sequence[Path], format: str) -> Path | None:
    """The file beside a calibration to be written; None if the format has a key for it, or it goes to a device."""
    if format == NAME or (paths[0].exists() and not paths[0].is_file()):
        return None
    return prior_file(paths[0])


def with_prior(text: str, content: dict[str, Any] | None) -> str:
    """The text of a calib.json with this prior on one line; None removes a prior that is there."""
    old = document("calib.json", text, Syntax.JSON)
    if old.content.get(KEY) == content:
        return text
    empty = old.with_values({(KEY,): None})  # only this key may change how the text is laid out
    return empty if content is None else document("calib.json", empty, Syntax.JSON).with_values({(KEY,): content})
