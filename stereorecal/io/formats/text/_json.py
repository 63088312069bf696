"""JSON: parsed, and changed by replacing the characters of single values."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._strict_json import parse_json
from stereorecal.io.formats.text._splice import Edit, Values, spliced

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[][{},:]|[^][{},:"\s]+')


def parsed(text: str) -> dict[str, Any]:
    """The keys and values of a JSON object."""
    content = parse_json(text)
    if not isinstance(content, dict):
        raise InputError("there is no JSON object of named values in the file; correct it.")
    return content


def with_values(text: str, values: Values) -> str:
    """The text with other values: every character that is none of theirs stays. Where a key is new, the text is written
    again, with the same keys in the same order, and the same indentation."""
    tokens = _TOKEN.finditer(text)
    root = _node(next(tokens), tokens)
    edits: list[Edit] = []
    for keys, value in values.items():
        node: _Node | None = root
        for key in keys:
            node = node and node.inside.get(key)
        if node is None:
            return _written_again(text, values)
        edits += _edits(text, node, value)
    return spliced(text, edits)


@dataclass(frozen=True)
class _Node:
    """Where a value stands, and by key or index those inside it."""

    start: int
    end: int
    inside: dict[str | int, "_Node"]


def _node(first: re.Match[str], tokens: Iterator[re.Match[str]]) -> _Node:
    """The value that begins with `first`, of a text that was parsed before; takes its other tokens."""
    inside: dict[str | int, _Node] = {}
    if first[0] not in ("{", "["):
        return _Node(first.start(), first.end(), inside)
    for token in tokens:
        if token[0] in ("}", "]"):
            return _Node(first.start(), token.end(), inside)
        if token[0] == ",":
            continue
        if first[0] == "{":
            next(tokens)  # the colon
            inside[json.loads(token[0])] = _node(next(tokens), tokens)
        else:
            inside[len(inside)] = _node(token, tokens)
    raise AssertionError("the text was parsed before")


def _edits(text: str, node: _Node, value: Any) -> Iterator[Edit]:
    old = json.loads(text[node.start : node.end])
    if isinstance(old, list) and isinstance(value, list) and len(old) == len(value):
        for index, item in enumerate(value):
            yield from _edits(text, node.inside[index], item)
    elif old != value:
        yield node.start, node.end, json.dumps(value, allow_nan=False, ensure_ascii=text.isascii())


def _written_again(text: str, values: Values) -> str:
    content: Any = parsed(text)
    for keys, value in values.items():
        place = content
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = value
    found = re.search(r"\n([ \t]+)\S", text)
    separators = None if found or ", " in text else (",", ":")
    indent = None if found is None else found[1]
    end = "\n" if text.endswith("\n") else ""
    return json.dumps(content, indent=indent, separators=separators, allow_nan=False, ensure_ascii=text.isascii()) + end
