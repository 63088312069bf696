"""What the module of a layout offers."""

from pathlib import Path
from typing import Protocol, runtime_checkable

from stereorecal.recordings import Log


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
        """The log in the folder, of each sequence the first `limit` pairs or all.

        Raises:
            InputError: naming the file, if something is missing or damaged.
            UnsupportedModelError: if the model of a lens is not known.
        """
        ...
