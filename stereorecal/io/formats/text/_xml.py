"""XML as OpenCV's FileStorage writes it."""

import re
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from stereorecal._errors import InputError
from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Edit, Keys, Values, leaves, missing, number_text, spliced

_DAMAGED = "not an XML file as OpenCV writes it, or truncated; correct or copy it again."
_TAG = re.compile(r"<([^\s/>]+)(?:\"[^\"]*\"|'[^']*'|[^\"'>])*?(/?)>")


@dataclass
class _Element:
    """An element, and where its text stands: from the end of its tag to the first element or comment in it."""

    name: str
    start: int
    text: str = ""
    end: int = 0
    inside: list["_Element"] = field(default_factory=list)


def parsed(text: str) -> dict[str, Any]:
    """The keys and values below the root."""
    content = _plain(_root(text))
    if not isinstance(content, dict):
        raise InputError(_DAMAGED)
    return content


def with_values(text: str, values: Values) -> str:
    """The text with other values; everything else stays."""
    root, data = _root(text), text.encode().decode("latin-1")  # a character for each byte, as the parser counts
    edits = [_edit(data, root, keys, " ".join(map(number_text, leaves(value)))) for keys, value in values.items()]
    return spliced(data, edits).encode("latin-1").decode()


def _root(text: str) -> _Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # OpenCV writes none, and entities can grow without end
        raise InputError(_DAMAGED)
    parser, beside = expat.ParserCreate("utf-8"), len(text) - len(text.lstrip())
    document = _Element("", 0)
    path = [document]

    def end_text() -> None:
        path[-1].end = path[-1].end or parser.CurrentByteIndex + beside

    def start(name: str, _: object) -> None:
        end_text()
        path.append(_Element(name, parser.CurrentByteIndex + beside))
        path[-2].inside.append(path[-1])

    def end(_: object) -> None:
        end_text()
        path.pop()

    def characters(found: str) -> None:
        path[-1].text += "" if path[-1].end else found

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.CommentHandler = characters, lambda _: end_text()
    try:
        parser.Parse(text.lstrip().encode(), True)
    except (expat.ExpatError, ValueError):
        raise InputError(_DAMAGED) from None
    return document.inside[0]


def _edit(data: str, element: _Element, keys: Keys, new: str) -> Edit:
    for key in keys:
        found = next((child for child in element.inside if child.name == str(key)), None)
        if found is None:
            raise missing(key)
        element = found
    tag = _TAG.match(data, element.start)
    assert tag is not None, "the text was parsed before"
    if tag[2]:  # <data/>
        return tag.end() - 2, tag.end(), f">{new}</{tag[1]}>"
    return tag.end(), element.end, new


def _plain(element: _Element) -> Any:
    if element.inside and all(child.name == "_" for child in element.inside):
        return [_plain(child) for child in element.inside]
    if element.inside:
        return without_duplicates([(child.name, _plain(child)) for child in element.inside])
    text = element.text.strip()
    if text.startswith('"'):
        return text.strip('"')
    words = [_word(word) for word in text.split()]
    return words[0] if len(words) == 1 and element.name != "data" else words


def _word(word: str) -> float | int | str:
    number = number_or_word(word.replace(".Inf", "inf").replace(".Nan", "nan"))
    return int(number) if isinstance(number, float) and re.fullmatch(r"[-+]?\d{1,15}", word) else number
