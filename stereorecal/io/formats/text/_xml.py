"""XML as OpenCV's FileStorage writes it."""

import io
import re
from typing import TYPE_CHECKING, Any

from stereorecal._errors import InputError
from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Keys, Values, leaves, number_text

if TYPE_CHECKING:
    from xml.etree import ElementTree

_BESIDE = re.compile(r"(?:\s|<\?.*?\?>|<!--.*?-->)*", re.DOTALL)  # the root
_DAMAGED = "not an XML file as OpenCV writes it, or truncated; correct or copy it again."


def parsed(text: str) -> dict[str, Any]:
    """The keys and values below the root.

    Raises:
        InputError: if it is no XML, or a key occurs twice with different numbers.
    """
    content = _plain_element(_root(text))
    if not isinstance(content, dict):
        raise InputError(_DAMAGED)
    return content


def with_values(text: str, values: Values) -> str:
    """The text with other values; comments stay.

    Raises:
        InputError: if a key is missing.
    """
    from xml.etree import ElementTree

    root = _root(text)
    for keys, value in values.items():
        _element(root, keys).text = " ".join(number_text(leaf) for leaf in leaves(value))
    file = io.StringIO()
    root.tail = None
    ElementTree.ElementTree(root).write(file, encoding="unicode")
    head = _BESIDE.match(text)
    end = f"</{root.tag}>"
    tail = text[text.rindex(end) + len(end) :] if end in text else ""
    return (head[0] if head else "") + file.getvalue() + (tail or "\n")


def _root(text: str) -> "ElementTree.Element":
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # OpenCV writes none, and entities can grow without end
        raise InputError(_DAMAGED)
    from xml.etree import ElementTree  # as long to import as all of YAML, and few files need it

    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    try:
        return ElementTree.fromstring(text.lstrip(), parser)
    except (ElementTree.ParseError, ValueError):
        raise InputError(_DAMAGED) from None


def _element(element: "ElementTree.Element", keys: Keys) -> "ElementTree.Element":
    for key in keys:
        found = element.find(str(key))
        if found is None:
            raise InputError(f"the key {key!r} is missing; add it, or copy the file again.")
        element = found
    return element


def _plain_element(element: "ElementTree.Element") -> Any:
    children = [child for child in element if isinstance(child.tag, str)]
    if children and all(child.tag == "_" for child in children):
        return [_plain_element(child) for child in children]
    if children:
        return without_duplicates([(child.tag, _plain_element(child)) for child in children])
    text = (element.text or "").strip()
    if text.startswith('"'):
        return text.strip('"')
    words = [_word(word) for word in text.split()]
    return words[0] if len(words) == 1 and element.tag != "data" else words


def _word(word: str) -> float | int | str:
    number = number_or_word(word.replace(".Inf", "inf").replace(".Nan", "nan"))
    return int(number) if isinstance(number, float) and re.fullmatch(r"[-+]?\d{1,15}", word) else number
