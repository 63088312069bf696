"""XML as OpenCV's FileStorage writes it: its values, and where they stand."""

import re
from collections.abc import Iterator
from xml.parsers import expat

from stereorecal._errors import InputError
from stereorecal.io.formats.text._nodes import Node, mapping, words

_DAMAGED = "not an XML file as OpenCV writes it, or truncated; correct or copy it again."
_ATTRIBUTES = r"""(?:"[^"]*"|'[^']*'|[^>"'])*?"""
_TAG = re.compile(rf"<!--.*?-->|<\?.*?\?>|<(?P<ends>/?)(?P<name>[^\s/>]+){_ATTRIBUTES}(?P<empty>/?)>", re.DOTALL)


def tree(text: str) -> tuple[str, Node]:
    """The text, and the keys and values below the root."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # OpenCV writes none, and entities can grow without end
        raise InputError(_DAMAGED)
    try:
        expat.ParserCreate("utf-8").Parse(text.lstrip().encode(), True)
    except (expat.ExpatError, ValueError):
        raise InputError(_DAMAGED) from None
    tags = _TAG.finditer(text)
    root = _node(text, next(tag for tag in tags if tag["name"]), tags)
    if not isinstance(root.value, dict):
        raise InputError(_DAMAGED)
    return text, root


def _node(text: str, first: re.Match[str], tags: Iterator[re.Match[str]]) -> Node:
    """The element that begins with `first`; takes its other tags. Its text goes to the first tag or comment in it."""
    start, inside = first.end(), list[tuple[str, Node]]()
    end = start if first["empty"] else text.index("<", start)
    for tag in () if first["empty"] else tags:
        if tag["ends"]:
            break
        if tag["name"]:
            inside.append((tag["name"], _node(text, tag, tags)))
    if inside and all(name == "_" for name, _ in inside):
        return Node([node for _, node in inside], start, end)
    if inside:
        return mapping(inside, start, end)
    if (quoted := text[start:end].strip()).startswith('"'):
        return Node(quoted.strip('"'), start, end)
    found = words(text, start, end)
    return found.value[0] if len(found.value) == 1 and first["name"] != "data" else found
