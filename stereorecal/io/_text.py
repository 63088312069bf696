"""Text files, read strictly."""

from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._inputs import note_input

_MOST = 1 << 26  # characters


def read_text(path: Path, if_missing: str = "add it.") -> str:
    """The text of a UTF-8 file, without byte order mark; ends of lines are those of the file.

    Args:
        if_missing: the end of the message if the file does not exist: what to do about it.

    Raises:
        InputError: naming the file, if it is missing, unreadable, empty or not UTF-8.
    """
    note_input(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = file.read(_MOST + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; {if_missing}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8; copy or write it again.") from None
    if len(text) > _MOST:
        raise InputError(f"{path}: the text has more than {_MOST >> 20} MB; check that this is the right file.")
    if not text.strip():
        raise InputError(f"{path}: the file is empty; copy or write it again.")
    return text
