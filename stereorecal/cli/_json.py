"""JSON for a file or for a pipe."""

import sys
from collections.abc import Mapping
from typing import Any

from stereorecal.cli._places import written_or_printed
from stereorecal.io import json_text, write_text


def write_json(content: Mapping[str, Any], target: str, *, force: bool) -> None:
    """Write to the file `target`, whole or not at all, or to stdout for "-". A number that is not finite is null.

    Args:
        force: whether a file is replaced that was not there when the command began, but is now.

    Raises:
        InputError: if it cannot be written to the file; it is printed then.
    """
    text = json_text(dict(content))
    if target == "-":
        sys.stdout.write(text)
    else:
        written_or_printed(lambda: write_text(target, text, replace=force), lambda: text)
