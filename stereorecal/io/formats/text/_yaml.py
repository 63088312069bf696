"""YAML: its values, and where they stand."""

import math
import re
from dataclasses import replace

import yaml
from yaml.composer import Composer
from yaml.nodes import MappingNode, ScalarNode, SequenceNode

from stereorecal._errors import InputError
from stereorecal.io.formats.text._nodes import DOCUMENTS, Node, mapping, number_or_word

_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
_MAP = re.compile(r"\[[-+.\deEinfaN,\s]{16384,}\]")  # numbers, thousands of them
_END = re.compile(r"(\n(---|\.\.\.)[ \t\r]*)+\s*\Z")  # after a message, as `ros2 topic echo` writes it
_NO_SPACE = re.compile(r"^([ \t]*[\w.]+:)\[", re.MULTILINE)  # data:[1], which OpenCV reads, and YAML does not
_MERGED = "<<"  # stands before the keys of other mappings
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

SEVERAL = "it holds several YAML documents; keep the one of the calibration."
DAMAGED = "not a YAML file, or truncated; correct or copy it again."


def tree(text: str) -> tuple[str, Node]:
    """The text, with a space after a colon where YAML needs one, and its keys and values, as OpenCV, ROS and Kalibr
    write them: `%YAML:1.0`, tags and all. Several documents of the same keys, as messages that were printed one after
    the other, are a list under `documents`."""
    text = _NO_SPACE.sub(r"\1 [", text)
    body = text.lstrip(_MARK)
    try:
        root = _node(_composed(body), body, len(text) - len(body))
    except (yaml.YAMLError, UnicodeError, RecursionError):
        raise InputError(DAMAGED) from None
    if not isinstance(root.value, dict):
        raise InputError(DAMAGED)
    return text, root


def _composed(text: str) -> yaml.Node:
    # Directives say nothing of numbers, and OpenCV's is none of YAML; a comment of the same length leaves all places
    # where they are.
    text = re.sub(r"\A%", "#", text)
    text = _END.sub("", text)
    # Maps for rectification take a parser minutes, and are not needed: they are read as empty lists, and stay.
    text = _MAP.sub(lambda found: f"[{' ' * (len(found[0]) - 2)}]", text)
    found: list[yaml.Node] = list(yaml.compose_all(text, _Loader))
    nodes = [node for node in found if len(found) == 1 or not isinstance(node, ScalarNode) or node.value]
    if not nodes:
        raise InputError(DAMAGED)
    node = nodes[0] if len(nodes) == 1 else _list_of(nodes)
    if _count(node, {}) > len(text) + _EXPANDED:
        raise InputError("its aliases expand to more than a calibration has; check that this is the right file.")
    return node


def _list_of(nodes: list[yaml.Node]) -> yaml.Node:
    """Several documents as one."""
    keys = {frozenset(str(key.value) for key, _ in one.value) for one in nodes if isinstance(one, MappingNode)}
    if len(keys) != 1 or not all(isinstance(one, MappingNode) for one in nodes):
        raise InputError(SEVERAL)
    return MappingNode("map", [(ScalarNode("word", DOCUMENTS), SequenceNode("list", nodes))])


def _count(node: yaml.Node, known: dict[int, float]) -> float:
    """How many nodes there are once aliases are written out; each is visited once. One within itself has no end."""
    if id(node) not in known:
        known[id(node)] = math.inf
        inside = [] if isinstance(node, ScalarNode) else node.value
        pairs = isinstance(node, MappingNode)
        parts = [part for item in inside for part in (item if pairs else (item,))]
        known[id(node)] = 1 + sum(_count(part, known) for part in parts)
    return known[id(node)]


def _node(node: yaml.Node, text: str, before: int) -> Node:
    """A node whose places count what stands before the text, too."""
    start, end = (before + mark.index for mark in (node.start_mark, node.end_mark)) if node.start_mark else (0, 0)
    if isinstance(node, MappingNode):
        pairs = [(key.value, _node(value, text, before)) for key, value in node.value if isinstance(key, ScalarNode)]
        made = mapping([(key, value) for key, value in pairs if key != _MERGED], start, end)
        for merged in (value.value for key, value in pairs if key == _MERGED):
            for one in merged if isinstance(merged, list) else [Node(merged, start, end)]:
                made = replace(made, value={**(one.value if isinstance(one.value, dict) else {}), **made.value})
        return made
    if isinstance(node, SequenceNode):
        items = [_node(item, text, before) for item in node.value]
        if node.flow_style or not items:
            return Node(items, start, end)
        last = items[-1].start - before
        line = text[text.rfind("\n", 0, last) + 1 : last]  # what begins an item in a line of its own
        return Node(items, start, end, "\n" + re.sub(r"[^-\s].*", "", line))
    if not isinstance(node, ScalarNode) or node.style:
        return Node(node.value, start, end)
    return Node(_WORDS.get(node.value.lower(), number_or_word(node.value)), start, end)
