"""XML as OpenCV's FileStorage writes it: its values, and where they stand."""

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from stereorecal._errors import InputError
from stereorecal.io.formats.text._nodes import Node, mapping, words

_DAMAGED = "not an XML file as OpenCV writes it, or truncated; correct or copy it again."
_ATTRIBUTES = r"""(?:"[^"]*"|'[^']*'|[^>"'])*?"""
_TAG = re.compile(rf"<!--.*?-->|<\?.*?\?>|<(?P<ends>/?)(?P<name>[^\s/>]+){_ATTRIBUTES}(?P<empty>/?)>", re.DOTALL)


@dataclass
class _Element:
    """An element; its text goes from `start` to the first tag or comment in it, at `end`."""

    name: str
    start: int
    end: int | None = None
    inside: list["_Element"] = field(default_factory=list)


def tree(text: str) -> tuple[str, Node]:
    """The text, and the keys and values below the root."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # OpenCV writes none, and entities can grow without end
        raise InputError(_DAMAGED)
    try:
        expat.ParserCreate("utf-8").Parse(text.lstrip().encode(), True)
    except (expat.ExpatError, ValueError):
        raise InputError(_DAMAGED) from None
    path = [_Element("", 0)]
    for tag in _TAG.finditer(text):
        path[-1].end = tag.start() if path[-1].end is None else path[-1].end
        if tag["name"] and not tag["ends"]:
            path.append(_Element(tag["name"], tag.end()))
            path[-2].inside.append(path[-1])
        if tag["ends"] or tag["empty"]:
            path.pop()
    root = _node(text, path[0].inside[0])
    if not isinstance(root.value, dict):
        raise InputError(_DAMAGED)
    return text, root


def _node(text: str, element: _Element) -> Node:
    start, end = element.start, element.start if element.end is None else element.end
    if element.inside and all(child.name == "_" for child in element.inside):
        return Node([_node(text, child) for child in element.inside], start, end)
    if element.inside:
        return mapping([(child.name, _node(text, child)) for child in element.inside], start, end)
    if (quoted := text[start:end].strip()).startswith('"'):
        return Node(quoted.strip('"'), start, end)
    found = words(text, start, end)
    return found.value[0] if len(found.value) == 1 and element.name != "data" else found
