"""What a calibration format is, and what its reader and its writer work with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats.text._document import Document, Syntax
from stereorecal.io.formats.text._nodes import Values

Documents = tuple[Document, ...]  # one, or those of the left and of the right camera
Cameras = Mapping[int, Camera]  # by side: 0 the left one, 1 the right one
YAML, JSON, COLONS = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}, {".json": Syntax.JSON}, {".txt": Syntax.COLONS}


@dataclass(frozen=True)
class Hints:
    """What a file may leave open.

    Attributes:
        size: (width, height) of the images in pixels.
        cameras: the names of the left and the right camera, as `_read_rig.py` has them.
        rectified: of a file of cameras and of their rectified images, which of these the images are.
    """

    size: tuple[int, int] | None = None
    cameras: tuple[str, str] | None = None
    rectified: bool | None = None

    def needed_size(self, lack: str) -> tuple[int, int]:
        """The size of the images, where the file says none; `lack`: what it has not, for the message."""
        if self.size is None:
            raise InputError(f"{lack}; give size=(width, height), on the command line --size WxH.")
        return self.size

    def mode_among(self, sizes: Sequence[tuple[int, int]]) -> tuple[int, int]:
        """The size of the images, where a file has the calibration of a device at each of these sizes."""
        listed = ", ".join(f"{width}x{height}" for width, height in sorted(sizes))
        if not sizes:
            raise InputError("there is no image size at which the file has both cameras; save the calibration again.")
        if len(sizes) > 1:
            self.needed_size(f"the file has calibrations for images of {listed}")
        if self.size is not None and self.size not in sizes:
            width, height = self.size
            raise InputError(
                f"the images are {width}x{height}, and the file has calibrations for {listed}; use images of one of "
                "these sizes, or give one of them and change the rig: rig.resized(size), rig.cropped(size)."
            )
        return self.size or sizes[0]


@dataclass(frozen=True)
class Format:
    """One format, with lengths in the file's own unit on both ways. What is wrong with a document is for `read` to say,
    in an InputError, which names the file, if there are two; what the format cannot hold, for `blank` and `write`, in
    one that names a format that can."""

    name: str  # as people write it after `--to`
    about: str  # what it is, and its files, in a few words
    unit: str | None  # of length, "m", "cm" or "mm"; None if the format says none
    looks: Callable[[Document], bool]  # whether a document, and each of two, looks like this format
    read: Callable[[Documents, Hints], StereoRig]  # makes the rig, with T in the file's unit
    one_size: bool = False  # whether it has one size of images for both cameras
    files: int = 1  # how many a new calibration takes: 1, or 2, one for each camera
    looks_together: Callable[[Documents], bool] | None = None  # `looks`, where numbers may be in any number of files
    # Names the cameras: the first two are read unless hints name others. None if the files name none.
    cameras: Callable[[Documents], Sequence[str]] | None = None
    # Endings of file names, and what is written into such a file; the first is usual. None: read only.
    syntax: Mapping[str, Syntax] = field(default_factory=dict)
    blank: Callable[[StereoRig, Syntax], Sequence[str]] = lambda rig, syntax: ()  # new files: all keys, any numbers
    # What to write into each document, which was read with these hints: the extrinsics, the intrinsics of the cameras
    # that have changed, and what is derived.
    write: Callable[[StereoRig, Documents, Hints, Cameras], Sequence[Values]] = lambda *_: ()

    def can_read(self, documents: Documents) -> bool:
        """Whether documents look like this format."""
        if self.looks_together is not None:
            return self.looks_together(documents)
        return len(documents) == self.files and all(map(self.looks, documents))
