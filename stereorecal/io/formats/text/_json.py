"""JSON: its values, and where they stand."""

import json
import re
from collections.abc import Iterator
from functools import partial, reduce
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._strict_json import parse_json
from stereorecal.io.formats.text._nodes import Node, Values, at, with_values as spliced

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[][{}]|[^][{},:"\s]+')  # commas and colons tell nothing new


def parsed(text: str) -> dict[str, Any]:
    """The keys and values of a JSON object."""
    content = parse_json(text)
    if not isinstance(content, dict):
        raise InputError("there is no JSON object of named values in the file; correct it.")
    return content


def with_values(text: str, values: Values) -> str:
    """The text with other values. A new key comes last in its object."""
    content = parsed(text)
    new = {keys: value for keys, value in values.items() if keys[-1] not in at(content, keys[:-1])}
    spelt = partial(json.dumps, allow_nan=False, ensure_ascii=text.isascii())
    text = spliced(text, _tree(text), {keys: value for keys, value in values.items() if keys not in new}, spelt)
    for (*above, key), value in new.items():
        place = reduce(lambda node, name: node.value[name], above, _tree(text))
        end = [*place.value.values()][-1].end
        line = re.search(r"\n[ \t]+", text[place.start : end])
        space = " " if line or ", " in text else ""
        text = f"{text[:end]},{line[0] if line else space}{json.dumps(key)}:{space}{spelt(value)}{text[end:]}"
    return text


def _tree(text: str) -> Node:
    tokens = _TOKEN.finditer(text)
    return _node(next(tokens), tokens)


def _node(first: re.Match[str], tokens: Iterator[re.Match[str]]) -> Node:
    """The value that begins with `first`, of a text that was parsed before; takes its other tokens."""
    if first[0] not in ("{", "["):
        return Node(json.loads(first[0]), first.start(), first.end())
    keys: dict[str, Node] = {}
    items: list[Node] = []
    for token in tokens:
        if token[0] in ("}", "]"):
            return Node(keys if first[0] == "{" else items, first.start(), token.end())
        if first[0] == "{":
            keys[json.loads(token[0])] = _node(next(tokens), tokens)
        else:
            items.append(_node(token, tokens))
    raise AssertionError("the text was parsed before")
