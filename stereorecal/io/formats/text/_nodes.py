"""The tree of a text: its values, and the characters that each of them takes; and texts in which only values change."""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._strict_json import without_duplicates

Keys = tuple[str | int, ...]
Values = Mapping[Keys, Any]  # numbers, words, or nested lists of them
Edit = tuple[int, int, str]  # from, to, what stands there then
DOCUMENTS = "documents"  # the key of several documents in one text
_WORD = re.compile(r"\S+")
_WHOLE = re.compile(r"[-+]?\d{1,15}")
_NOT_FINITE = re.compile(r"\A([-+]?)\.(inf|nan)\Z", re.IGNORECASE)  # as YAML and OpenCV write them


@dataclass(frozen=True)
class Node:
    """A value of a text."""

    value: Any  # a number, a word, a truth or None; or the nodes inside, by their keys or as a list
    start: int  # the characters from `start` to before `end`
    end: int
    between: str = ", "  # what separates two items of a list, if it has fewer


def mapping(pairs: Sequence[tuple[str, Node]], start: int, end: int) -> Node:
    """A node of keys and the nodes under them; a number may not be said twice."""
    without_duplicates([(key, plain(node)) for key, node in pairs])
    return Node(dict(pairs), start, end)


def number_or_word(word: str) -> float | int | str:
    """A word of a text file as a number if it is one, else as it is."""
    if not word.isascii() or "_" in word:  # float() would read "1_0" as 10
        return word
    try:
        return int(word) if _WHOLE.fullmatch(word) else float(_NOT_FINITE.sub(r"\1\2", word))
    except ValueError:
        return word


def words(text: str, start: int, end: int) -> Node:
    """A node of the words in a part of a text, and what each of them says."""
    nodes = [Node(number_or_word(one[0]), *one.span()) for one in _WORD.finditer(text, start, end)]
    return Node(nodes, start, end, between=" ")


def plain(node: Node) -> Any:
    """The value of a node, of which nothing says where it stands."""
    if isinstance(node.value, dict):
        return {key: plain(inside) for key, inside in node.value.items()}
    return [plain(inside) for inside in node.value] if isinstance(node.value, list) else node.value


def with_values(text: str, root: Node, values: Values, spelt: Callable[[Any], str]) -> str:
    """The text with other values: of a list, only the numbers that differ; every other character stays."""
    edits, places = set[Edit](), Counter(_places(root))
    for keys, value in values.items():
        node = root
        for key in keys:
            try:
                node = node.value[key]
            except (KeyError, IndexError, TypeError):
                raise InputError(f"the key {key!r} is missing; add it, or copy the file again.") from None
        new = set(_edits(text, node, value, spelt))
        if new and places[node.start, node.end] > 1:
            name = ".".join(map(str, keys))
            raise InputError(
                f"{name} stands once for several keys (YAML's & and *); write it out for each, or write a new file: "
                "`dataclasses.replace(rig, source=None)`."
            )
        edits |= new
    for start, end, new in sorted(edits, reverse=True):  # of two that touch, the one that inserts is the later
        text = text[:start] + new + text[end:]
    return text


def _places(node: Node) -> Iterator[tuple[int, int]]:
    """Where the values and lists of a tree stand; one that YAML's aliases repeat, repeatedly."""
    inside = node.value.values() if isinstance(node.value, dict) else node.value if isinstance(node.value, list) else ()
    if isinstance(node.value, dict) or any(isinstance(one.value, dict) for one in inside):
        for one in inside:
            yield from _places(one)
    else:
        yield node.start, node.end


def _edits(text: str, node: Node, value: Any, spelt: Callable[[Any], str]) -> Iterator[Edit]:
    if not (isinstance(node.value, list) and isinstance(value, list)):
        if plain(node) != value:
            yield node.start, node.end, " " * (node.start == node.end) + spelt(value)
        return
    old, new = list(_scalars(node)), list(leaves(value))
    for one, number in zip(old, new, strict=False):
        if one.value != number:
            yield one.start, one.end, spelt(number)
    if not old:
        inside = node.start + (text[node.start : node.start + 1] == "[")
        yield inside, inside, node.between.join(map(spelt, new))
    elif len(new) > len(old):
        between = re.sub(r"[ \t]*#[^\n]*", "", text[old[-2].end : old[-1].start]) if len(old) > 1 else node.between
        yield old[-1].end, old[-1].end, "".join(between + spelt(number) for number in new[len(old) :])
    elif len(new) < len(old):
        yield old[len(new) - 1].end, old[-1].end, ""


def _scalars(node: Node) -> Iterator[Node]:
    if not isinstance(node.value, list):
        yield node
        return
    for inside in node.value:
        yield from _scalars(inside)


def number_text(value: Any) -> str:
    """A number with all its digits, written so that every reader of YAML 1.1 takes it for a number; a word as it is."""
    if isinstance(value, str | int):
        return str(value)
    if not isinstance(value, float):
        raise InputError("a value to be written is a list where the file has none; write a new file.")
    mantissa, exponent, power = repr(value + 0.0).partition("e")  # no -0.0
    return f"{mantissa}{'' if '.' in mantissa or not exponent else '.0'}{exponent}{power}"


def leaves(value: Any, levels: int = 4) -> Iterator[Any]:
    """What nested lists contain; one that is nested deeper than any matrix, as it is."""
    if isinstance(value, list) and levels:
        for item in value:
            yield from leaves(item, levels - 1)
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
