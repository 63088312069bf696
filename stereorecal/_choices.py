"""Names that users give, checked against the known ones."""

import difflib
from collections.abc import Iterable

from stereorecal._errors import InputError


def checked_choice(name: str, names: Iterable[str], what: str) -> str:
    """`name`, if it is one of `names`.

    Args:
        what: what the name is of, for the message.

    Raises:
        InputError: otherwise; the message suggests the nearest name.
    """
    names = list(names)
    if name in names:
        return name
    close = difflib.get_close_matches(name, names, 1)
    hint = f"did you mean {close[0]}?" if close else f"choose one of: {', '.join(names)}."
    raise InputError(f"unknown {what} {name!r}; {hint}")
