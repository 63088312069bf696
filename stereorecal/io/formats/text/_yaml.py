"""YAML: read as plain values, and changed by replacing the characters of single numbers."""

import math
import re
from collections.abc import Iterator
from functools import reduce
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from stereorecal._errors import InputError
from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Edit, Values, missing, number_text, spliced

_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
_NOT_FINITE = re.compile(r"([-+]?)\.(inf|nan)", re.IGNORECASE)
_MAP = re.compile(r"\[[-+.\deEinfaN,\s]{16384,}\]")  # numbers, thousands of them
_END = re.compile(r"(\n(---|\.\.\.)[ \t\r]*)+\s*\Z")  # after a message, as `ros2 topic echo` writes it
_NO_SPACE = re.compile(r"^([ \t]*[\w.]+:)\[", re.MULTILINE)  # data:[1], which OpenCV reads, and YAML does not
_MERGED = "<<"  # keys of other mappings, which no calibration file needs
_MARK = "\ufeff"  # of the order of bytes, which libyaml does not count among the characters
_EXPANDED = 100_000  # nodes that aliases may add

if yaml.__with_libyaml__:
    from yaml.cyaml import CParser  # pyright: ignore[reportAttributeAccessIssue]

    class _Loader(Composer, CParser, yaml.resolver.Resolver):
        """Words by libyaml, ten times as fast; nodes by Python, which ends at its limit of recursion, not at the
        stack's."""

        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            Composer.__init__(self)
            yaml.resolver.Resolver.__init__(self)
else:
    _Loader = yaml.SafeLoader  # pyright: ignore[reportAssignmentType]

DOCUMENTS = "documents"  # the key of several documents in one text
SEVERAL = "it holds several YAML documents; keep the one of the calibration."
DAMAGED = "not a YAML file, or truncated; correct or copy it again."


def parsed(text: str) -> dict[str, Any]:
    """The keys and values of a YAML text, as OpenCV, ROS and Kalibr write them: `%YAML:1.0`, tags and all. Several
    documents of the same keys, as messages that were printed one after the other, are a list under `documents`."""
    try:
        content = _plain_node(_composed(_spaced(text.lstrip(_MARK))))
    except RecursionError:
        raise InputError(DAMAGED) from None
    if not isinstance(content, dict):
        raise InputError(DAMAGED)
    return content


def with_values(text: str, values: Values) -> str:
    """The text with other numbers. Lists may grow; every character that is no number of theirs stays, but that a space
    is put after a colon where YAML needs one."""
    body = text.lstrip(_MARK)
    head, body = text[: len(text) - len(body)], _spaced(body)
    root = _composed(body)
    edits = [edit for keys, value in values.items() for edit in _edits(body, reduce(_child, keys, root), value)]
    return head + spliced(body, edits)


def _spaced(text: str) -> str:
    return _NO_SPACE.sub(r"\1 [", text)


def _composed(text: str) -> Node:
    # Directives say nothing of numbers, and OpenCV's is none of YAML; a comment of the same length leaves all places
    # where they are.
    text = re.sub(r"\A%", "#", text)
    text = _END.sub("", text)
    # Maps for rectification take a parser minutes, and are not needed: they are read as empty lists, and stay.
    text = _MAP.sub(lambda found: f"[{' ' * (len(found[0]) - 2)}]", text)
    try:
        nodes = list(yaml.compose_all(text, _Loader))
        nodes = [node for node in nodes if len(nodes) == 1 or not _is_empty(node)]
    except (yaml.YAMLError, UnicodeError, RecursionError):
        nodes = []
    node = nodes[0] if len(nodes) == 1 else _list_of(nodes) if nodes else None
    if node is None:
        raise InputError(DAMAGED)
    try:
        if _count(node, {}) > len(text) + _EXPANDED:
            raise InputError("its aliases expand to more than a calibration has; check that this is the right file.")
    except RecursionError:
        raise InputError(DAMAGED) from None
    return node


def _is_empty(node: Node) -> bool:
    return isinstance(node, ScalarNode) and not node.value


def _list_of(nodes: list[Node]) -> Node:
    """Several documents as one."""
    keys = {frozenset(str(key.value) for key, _ in one.value) for one in nodes if isinstance(one, MappingNode)}
    if len(keys) != 1 or not all(isinstance(one, MappingNode) for one in nodes):
        raise InputError(SEVERAL)
    return MappingNode("map", [(ScalarNode("word", DOCUMENTS), SequenceNode("list", nodes))])


def _count(node: Node, known: dict[int, float]) -> float:
    """How many nodes there are once aliases are written out; each is visited once. One within itself has no end."""
    if id(node) not in known:
        known[id(node)] = math.inf
        inside = [] if isinstance(node, ScalarNode) else node.value
        pairs = isinstance(node, MappingNode)
        parts = [part for item in inside for part in (item if pairs else (item,))]
        known[id(node)] = 1 + sum(_count(part, known) for part in parts)
    return known[id(node)]


def _plain_node(node: Node) -> Any:
    if isinstance(node, MappingNode):
        keys = [(key.value, value) for key, value in node.value if isinstance(key, ScalarNode)]
        pairs = [(key, _plain_node(value)) for key, value in keys if key != _MERGED]
        return without_duplicates(pairs)
    if isinstance(node, SequenceNode):
        return [_plain_node(item) for item in node.value]
    return _scalar(node.value) if isinstance(node, ScalarNode) and not node.style else node.value


def _scalar(word: str) -> Any:
    if word.lower() in _WORDS:
        return _WORDS[word.lower()]
    found = _NOT_FINITE.fullmatch(word)
    number = float(found[1] + found[2]) if found else number_or_word(word)
    whole = isinstance(number, float) and re.fullmatch(r"[-+]?\d{1,15}", word)
    return int(word) if whole else number


def _child(node: Node, key: str | int) -> Node:
    if isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key]
    if isinstance(node, MappingNode):
        for name, value in node.value:
            if isinstance(name, ScalarNode) and name.value == key:
                return value
    raise missing(key)


def _edits(text: str, node: Node, value: Any) -> Iterator[Edit]:
    if isinstance(node, ScalarNode) and not isinstance(value, list):
        if _plain_node(node) != value:
            start, end = node.start_mark.index, node.end_mark.index
            yield start, end, " " * (start == end) + number_text(value)
    elif isinstance(node, SequenceNode) and not node.value and node.flow_style and isinstance(value, list):
        yield node.start_mark.index, node.end_mark.index, f"[{', '.join(map(number_text, value))}]"
    elif isinstance(node, SequenceNode) and isinstance(value, list) and len(value) >= len(node.value) > 0:
        for item, new in zip(node.value, value, strict=False):
            yield from _edits(text, item, new)
        if len(value) > len(node.value):
            last = node.value[-1]
            between = ", " if node.flow_style else _new_item(text, last)
            place, more = last.end_mark.index, value[len(node.value) :]
            # Where the last number changes as well, its own edit comes first: they touch, but do not overlap.
            yield place, place, "".join(between + number_text(number) for number in more)
    else:
        raise InputError(
            "a value to be written is a list where the file has none, or one of another length; write a new file."
        )


def _new_item(text: str, last: Node) -> str:
    """What begins an item in a line of its own."""
    begin = text.rfind("\n", 0, last.start_mark.index) + 1
    return "\n" + re.sub(r"[^-\s].*", "", text[begin : last.start_mark.index])
