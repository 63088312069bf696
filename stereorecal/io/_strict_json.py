"""JSON, written uniformly and read strictly."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereorecal._arrays import json_data
from stereorecal._errors import InputError
from stereorecal.io._atomic import write_text
from stereorecal.io._read_files import AnyPath, about, read_text

# Far more than any file of this library has, and far below the depth at which Python's own recursion ends.
_DEEPEST = 100


def json_text(content: Any, *, sort_keys: bool = False) -> str:
    """`content` (dicts, lists, tuples, arrays, text, numbers, None) as indented JSON with a final newline.

    A number that is not finite becomes null.
    """
    return strict_json_text(json_data(content), sort_keys=sort_keys)


def json_line(content: Any) -> str:
    """As `json_text`, on one line: an entry of a .jsonl file."""
    return json.dumps(json_data(content), allow_nan=False) + "\n"


def write_json(path: AnyPath, content: Any) -> None:
    """Write `json_text(content)` to a file, whole or not at all; InputError if the place cannot be written to."""
    write_text(path, json_text(content))


def strict_json_text(content: Any, *, sort_keys: bool = False) -> str:
    """As `json_text`, for what must be read back as it was: nothing is converted and nothing becomes null."""
    return json.dumps(content, indent=1, sort_keys=sort_keys, allow_nan=False) + "\n"


def read_json(path: AnyPath) -> Any:
    """The content of a JSON file.

    Raises:
        InputError: naming the file, if it is missing, unreadable, empty, or refused by `parse_json`.
    """
    text = read_text(Path(path))
    with about(path):
        return parse_json(text)


def parse_json(text: str) -> Any:
    """The value of a JSON text; all numbers in it are finite.

    Raises:
        InputError: if the text is not valid JSON or nests more than 100 levels; naming the key, if it occurs twice
            with different numbers, or a number is NaN, infinite, or too large for a float64 (1e999, an
            integer of 5 000 digits).
    """
    try:
        content = json.loads(text, parse_int=_int, object_pairs_hook=without_duplicates)
        _check(content)
    except json.JSONDecodeError as error:
        raise InputError(f"not valid JSON, or truncated ({error}); correct or copy it again.") from error
    except RecursionError:
        raise InputError(f"the JSON nests more than {_DEEPEST} levels; check that this is the right file.") from None
    return content


def without_duplicates(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """The mapping of these pairs. Of two equal keys one reader takes the first and another one the last, which matters
    for numbers."""
    content: dict[str, Any] = {}
    for key, value in pairs:
        if key in content and content[key] != value and not isinstance(value, str | None):
            raise InputError(f"the key {key!r} occurs twice; keep the right one.")
        content[key] = value
    return content


def _int(token: str) -> float:
    # What fits into a float64 has at most 309 digits before the point, so int() does not meet Python's limit of digits.
    return int(token) if math.isfinite(number := float(token)) else number


def _check(content: Any, key: str = "the file", levels: int = _DEEPEST) -> None:
    """Refuse numbers that are not finite, and what nests too deep."""
    if levels < 0:
        raise RecursionError
    if isinstance(content, float) and not math.isfinite(content):
        limit = "put a finite number (at most 1.8e308), or null where none is known."
        raise InputError(f"{key} contains {json.dumps(content)}; {limit}")
    for name, value in content.items() if isinstance(content, dict) else ():
        _check(value, name, levels - 1)
    for value in content if isinstance(content, list) else ():
        _check(value, key, levels - 1)
