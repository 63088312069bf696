"""JSON for a file or for a pipe."""

import json
import sys
from collections.abc import Mapping
from typing import Any

from stereorecal._plain import plain
from stereorecal.io import write_text


def write_json(content: Mapping[str, Any], target: str) -> None:
    """Write to the file `target`, whole or not at all, or to stdout for "-". A number that is not finite is null."""
    text = json.dumps(plain(dict(content)), indent=1, allow_nan=False) + "\n"
    if target == "-":
        sys.stdout.write(text)
    else:
        write_text(target, text)
