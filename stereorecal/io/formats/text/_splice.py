"""Paths of keys in a text, the values under them, and texts in which only those change."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from stereorecal._errors import InputError

Keys = tuple[str | int, ...]
Values = Mapping[Keys, Any]  # numbers, words, or nested lists of them

Edit = tuple[int, int, str]  # from, to, what stands there then


def spliced(text: str, edits: Iterable[Edit]) -> str:
    """The text with these edits. Of two that touch, the one that inserts comes last in the text."""
    for start, end, new in sorted(set(edits), reverse=True):
        text = text[:start] + new + text[end:]
    return text


def missing(key: object) -> InputError:
    """What to raise where a key to write under is missing."""
    return InputError(f"the key {key!r} is missing; add it, or copy the file again.")


def under(place: Keys, keys: Iterable[str | int], values: Iterable[Any]) -> dict[Keys, Any]:
    """What to write below a place: a value under each key."""
    return {(*place, key): value for key, value in zip(keys, values, strict=True)}


def number_text(value: Any) -> str:
    """A number with all its digits, written so that every reader of YAML 1.1 takes it for a number."""
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return str(value)
    mantissa, exponent, power = repr(float(value) + 0.0).partition("e")  # no -0.0
    return f"{mantissa}{'' if '.' in mantissa or not exponent else '.0'}{exponent}{power}"


def leaves(value: Any) -> Iterator[Any]:
    """What nested lists contain."""
    if isinstance(value, list):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def at(content: Any, keys: Keys) -> Any:
    """The value that `keys` lead to; None if there is none."""
    for key in keys:
        try:
            content = content[key]
        except (KeyError, IndexError, TypeError):
            return None
    return content
