"""JSON, written uniformly and read strictly."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal._json_data import json_data
from stereorecal.io._atomic import write_text
from stereorecal.io._read_files import AnyPath, about, read_text

# Far more than any file of this library has, and far below the depth at which Python's own recursion ends.
_DEEPEST = 100
_SHOWN = 24  # characters of a refused number in a message


# --- writing ------------------------------------------------------------------------------------------------


def json_text(content: Any, *, sort_keys: bool = False) -> str:
    """`content` (dicts, lists, tuples, arrays, text, numbers, None) as indented JSON with a final newline.

    A number that is not finite becomes null.
    """
    return strict_json_text(json_data(content), sort_keys=sort_keys)


def json_line(content: Any) -> str:
    """As `json_text`, on one line: an entry of a .jsonl file."""
    return json.dumps(json_data(content), allow_nan=False) + "\n"


def write_json(path: AnyPath, content: Any) -> None:
    """Write `json_text(content)` to a file, whole or not at all.

    Raises:
        InputError: if the place cannot be written to.
    """
    write_text(path, json_text(content))


def strict_json_text(content: Any, *, sort_keys: bool = False) -> str:
    """As `json_text`, for what must be read back as it was: nothing is converted and nothing becomes null.

    Raises:
        TypeError, ValueError, RecursionError: if JSON cannot hold a value.
    """
    return json.dumps(content, indent=1, sort_keys=sort_keys, allow_nan=False) + "\n"


# --- reading ------------------------------------------------------------------------------------------------


def read_json(path: AnyPath, if_missing: str = "check the path.") -> Any:
    """The content of a JSON file.

    Args:
        if_missing: the end of the message if the file does not exist: what to do about it.

    Raises:
        InputError: naming the file, if it is missing, unreadable, empty, or refused by `parse_json`.
    """
    text = read_text(Path(path), if_missing)
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
        content = json.loads(
            text, parse_int=_int, parse_float=_float, parse_constant=_Refused, object_pairs_hook=without_duplicates
        )
    except json.JSONDecodeError as error:
        raise InputError(f"not valid JSON, or truncated ({error}); correct or copy it again.") from error
    except RecursionError:
        raise InputError(_TOO_DEEP) from None
    for keys, number in _refused_in(content):
        raise InputError(
            f"{'.'.join(keys) or 'the file'} contains {number}; put a finite number (at most 1.8e308), or null where "
            "none is known."
        )
    return content


def without_duplicates(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """The mapping of these pairs. Of two equal keys one reader takes the first and another one the last, which matters
    for numbers.

    Raises:
        InputError: names a key that occurs twice, with different numbers.
    """
    content: dict[str, Any] = {}
    for key, value in pairs:
        if key in content and content[key] != value and not isinstance(value, str | None):
            raise InputError(f"the key {key!r} occurs twice; keep the right one.")
        content[key] = value
    return content


_TOO_DEEP = f"the JSON nests more than {_DEEPEST} levels; check that this is the right file."


@dataclass(frozen=True)
class _Refused:
    """Stands for a number that cannot be used, until its key is known."""

    token: str

    def __str__(self) -> str:
        return self.token if len(self.token) <= _SHOWN else f"{self.token[:_SHOWN]}… ({len(self.token)} characters)"


def _int(token: str) -> int | _Refused:
    return _finite(token, int)


def _float(token: str) -> float | _Refused:
    return _finite(token, float)


def _finite(token: str, kind: Callable[[str], Any]) -> Any:
    # What fits into a float64 has at most 309 digits before the point, so int() does not meet Python's limit of digits.
    return kind(token) if math.isfinite(float(token)) else _Refused(token)


def _refused_in(content: Any, keys: tuple[str, ...] = (), depth: int = 0) -> Iterator[tuple[tuple[str, ...], _Refused]]:
    """Numbers that cannot be used, each with the keys that lead to it."""
    if depth > _DEEPEST:
        raise InputError(_TOO_DEEP)
    if isinstance(content, _Refused):
        yield keys, content
    elif isinstance(content, dict):
        for key, value in content.items():
            yield from _refused_in(value, (*keys, key), depth + 1)
    elif isinstance(content, list):
        for value in content:
            yield from _refused_in(value, keys, depth + 1)
