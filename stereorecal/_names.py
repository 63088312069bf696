"""Names that people give, checked against those that there are."""

import difflib
from collections.abc import Iterable

from stereorecal._errors import InputError


def known(name: str, names: Iterable[str], what: str) -> str:
    """`name` if it is one of `names`.

    Raises:
        InputError: otherwise; names the nearest.
    """
    names = list(names)
    if name in names:
        return name
    close = difflib.get_close_matches(name, names, 1)
    hint = f"did you mean {close[0]}?" if close else f"choose one of: {', '.join(names)}."
    raise InputError(f"unknown {what} {name!r}; {hint}")
