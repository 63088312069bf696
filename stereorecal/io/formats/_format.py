"""What the module of a calibration format offers, and what it works with."""

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from stereorecal.geometry import StereoRig
from stereorecal.io.formats.text._document import Document, Syntax

Documents = tuple[Document, ...]  # one, or those of the left and of the right camera


@dataclass(frozen=True)
class Hints:
    """What a file may leave open.

    Attributes:
        size: (width, height) of the images in pixels.
        cameras: the names of the left and the right camera, as `_camera_choice.py` has them.
        rectified: of a file of cameras and of their rectified images, which of these the images are.
        common_size: whether cameras of two sizes are read at the smaller one.
    """

    size: tuple[int, int] | None = None
    cameras: tuple[str, str] | None = None
    rectified: bool | None = None
    common_size: bool = False


@dataclass(frozen=True)
class Target:
    """Where a rig is to be written.

    Attributes:
        documents: the file that it came from, or one without numbers of its own.
        left, right: whether the intrinsics of that camera are to be written; else those in the file stay.
        hints: with which the documents were read.
    """

    documents: Documents
    left: bool = True
    right: bool = True
    hints: Hints = field(default_factory=Hints)


@runtime_checkable
class Format(Protocol):
    """A module that reads and writes one format. Lengths are in the file's own unit on both ways."""

    @property
    def NAME(self) -> str:
        """As people write it after `--to`."""
        ...

    @property
    def ABOUT(self) -> str:
        """What it is, and its files, in a few words."""
        ...

    @property
    def SYNTAX(self) -> dict[str, Syntax]:
        """Endings of file names, such as ".yaml", and what is written into such a file; the first is usual."""
        ...

    @property
    def FILES(self) -> int:
        """How many files a new calibration takes: 1, or 2, one for each camera."""
        ...

    @property
    def UNIT(self) -> str | None:
        """The unit of length, "m", "cm" or "mm"; None if the format says none."""
        ...

    def can_read(self, documents: Documents) -> bool:
        """Whether these look like this format; what is wrong with them is for `read` to say."""
        ...

    def read(self, documents: Documents, hints: Hints) -> StereoRig:
        """The rig, with T in the file's unit.

        Raises:
            InputError: if the values are not a valid calibration; naming the file, if there are two.
            UnsupportedModelError: if the model of a lens is not known.
        """
        ...

    def blank(self, rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
        """The texts of new files, with all keys; numbers may be anything.

        Raises:
            InputError: if the format cannot hold the rig; names one that can.
        """
        ...

    def write(self, rig: StereoRig, target: Target) -> tuple[str, ...]:
        """The texts of the documents with the extrinsics of the rig, with T in the file's unit, the intrinsics that the
        target asks for, and everything that is derived from them.

        Raises:
            InputError: if the format cannot hold the rig; names one that can.
        """
        ...
