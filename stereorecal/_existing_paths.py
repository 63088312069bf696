"""Files and folders that people name: whether they are there."""

import glob
from os import PathLike
from pathlib import Path

from stereorecal._errors import InputError


def check_exists(place: str | PathLike[str], what: str) -> None:
    """Refuse a place that does not exist, unless it is a pattern such as "left/*.png".

    Args:
        what: what should be there, for the message.

    Raises:
        InputError: names the place.
    """
    if not Path(place).exists() and glob.escape(str(place)) == str(place):
        raise InputError(f"{place}: there is no such {what}; check the path.")


def existing_folder(folder: str | PathLike[str]) -> Path:
    """The folder.

    Raises:
        InputError: if there is none of this name.
    """
    if Path(folder).is_file():
        raise InputError(f"{folder}: this is a file; give the folder of the recording.")
    if not Path(folder).is_dir():
        raise InputError(f"{folder}: there is no such folder; check the path.")
    return Path(folder)
