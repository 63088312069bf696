"""XML as OpenCV's FileStorage writes it: its values, and where they stand."""

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from stereorecal._errors import InputError
from stereorecal.io.formats.text._nodes import Node, mapping, number_or_word, words

_DAMAGED = "not an XML file as OpenCV writes it, or truncated; correct or copy it again."


@dataclass
class _Element:
    """An element; its text goes from `start` to the first element or comment in it, at `end`."""

    name: str
    start: int | None = None
    end: int | None = None
    inside: list["_Element"] = field(default_factory=list)


def tree(text: str) -> tuple[str, Node]:
    """The text, and the keys and values below the root."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # OpenCV writes none, and entities can grow without end
        raise InputError(_DAMAGED)
    parser, body = expat.ParserCreate("utf-8"), text.lstrip()
    data, beside = body.encode(), len(text) - len(body)
    path = [_Element("")]

    def here() -> int:
        at = parser.CurrentByteIndex
        return beside + (at if len(data) == len(body) else len(data[:at].decode()))

    def end_text() -> None:
        if path[-1].end is None:
            path[-1].end = here()

    def start(name: str, _: object) -> None:
        end_text()
        path.append(_Element(name))
        path[-2].inside.append(path[-1])

    def end(_: object) -> None:
        end_text()
        path.pop()

    def characters(_: str) -> None:
        if path[-1].start is None:
            path[-1].start = here()

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.CommentHandler = characters, lambda _: end_text()
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError):
        raise InputError(_DAMAGED) from None
    root = _node(text, path[0].inside[0])
    if not isinstance(root.value, dict):
        raise InputError(_DAMAGED)
    return text, root


def _node(text: str, element: _Element) -> Node:
    end = element.end or 0
    start = end if element.start is None else min(element.start, end)
    if element.inside and all(child.name == "_" for child in element.inside):
        return Node([_node(text, child) for child in element.inside], start, end)
    if element.inside:
        return mapping([(child.name, _node(text, child)) for child in element.inside], start, end)
    if (quoted := text[start:end].strip()).startswith('"'):
        return Node(quoted.strip('"'), start, end)
    found = words(text, start, end, _number_or_word)
    return found.value[0] if len(found.value) == 1 and element.name != "data" else found


def _number_or_word(word: str) -> float | int | str:
    number = number_or_word(word.replace(".Inf", "inf").replace(".Nan", "nan"))
    return int(number) if isinstance(number, float) and re.fullmatch(r"[-+]?\d{1,15}", word) else number
