"""One calibration file: its text, its syntax and its values."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._read_files import about, read_text
from stereorecal.io.formats.text import _json, _lines, _xml, _yaml
from stereorecal.io.formats.text._binary import binary_text
from stereorecal.io.formats.text._nodes import Node, Values, number_text, plain, with_values


class Syntax(Enum):
    """How a text says which value belongs to which key."""

    YAML = "YAML"
    XML = "XML"
    JSON = "JSON"
    COLONS = "lines 'key: values'"
    EQUALS = "lines 'key=values'"
    NUMBERS = "lines of numbers"
    SECTIONS = "ost.txt of ROS"
    INI = "INI file"
    DEVICES = "text of rs-enumerate-devices"


# Texts that are read and not written: whether a text looks like one, and its content.
_READ_ONLY: dict[Syntax, tuple[Callable[[str], object], Callable[[str], dict[str, Any]]]] = {
    Syntax.NUMBERS: (_lines.numbers_in, _lines.parsed_numbers),
    Syntax.SECTIONS: (_lines.looks_like_ost, _lines.parsed_ost),
    Syntax.DEVICES: (_lines.looks_like_devices, _lines.parsed_devices),
    Syntax.INI: (_lines.looks_like_ini, _lines.parsed_ini),
}
_TREES: dict[Syntax, Callable[[str], tuple[str, Node]]] = {
    Syntax.YAML: _yaml.tree,
    Syntax.XML: _xml.tree,
    Syntax.COLONS: _lines.colons,
    Syntax.EQUALS: _lines.equals,
}
# Parsers call themselves at each level of nesting. Nesting is no deeper than there are opening brackets and tags, or
# items begun on one line, or than indentation fits into the text.
_MOST_OPENINGS = 2000
_NESTED = "too long or too deeply nested for a calibration; check that this is the right file."
_LONGEST = 1 << 22  # characters; a calibration of a rig has a few thousand, and its rectifying maps some million
# Two numbers with nothing but a space between them are no YAML that anybody writes for a calibration.
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_COLONS = re.compile(rf"^\w+:[ \t]+{_NUMBER}[ \t]+{_NUMBER}(?!\S)", re.MULTILINE)
_SECTION = re.compile(r"\A\s*\[[A-Za-z_][^\]\n]*\]\s*(?:[;#].*)?$", re.MULTILINE)  # of an INI file
_PYTHON = re.compile(r"\{\s*(?:#[^\n]*\n\s*)*'")  # a dict with comments, as mrcal writes it, which YAML has, too
_YAML = re.compile(r"%YAML|---|[\w.\"'][\w.\"' -]{,100}:(?:[\s\[{]|\Z)")  # what its first line has
_EQUALS = re.compile(r"^\w+[ \t]*=", re.MULTILINE)


@dataclass(frozen=True)
class Document:
    """A text and what it says."""

    name: str  # what messages call the file
    text: str
    syntax: Syntax
    content: Mapping[str, Any]  # keys and plain values, matrices as the file has them

    def with_values(self, values: Values) -> str:
        """The text with other values under some keys, and everything else as it was."""
        with about(self.name):
            if not values:
                return self.text
            if self.syntax is Syntax.JSON:
                try:
                    return _json.with_values(self.text, values)
                except ValueError as error:  # of a number that is not finite
                    raise InputError(f"cannot be written as JSON ({error}); use plain finite values.") from None
            if self.syntax not in _TREES:
                raise InputError("a text without keys is read, not written; write a new file, such as calib.json.")
            return with_values(*_TREES[self.syntax](self.text), values, number_text)


def document(name: object, text: str, syntax: Syntax | None = None, *, lines: bool = True) -> Document:
    """A text, parsed; without a syntax as it looks, perhaps like `lines` of keys and values, or without any values."""
    with about(name):
        first = (line.strip() for line in text.splitlines() if not line.lstrip().startswith("#"))
        guessed = syntax is None and lines and not _YAML.match(next(filter(None, first), ""))
        syntax = syntax or _syntax_of(text, lines)
        try:
            if syntax is Syntax.JSON:  # whose parser looks after itself
                return Document(str(name), text, syntax, _json.parsed(text))
            # Before any parser sees it: what is too long for a calibration or may be nested too deeply.
            openings = sum(text.count(bracket) for bracket in "[{<")
            items = max((line.count("- ") for line in text.splitlines()), default=0)
            if len(text) > _LONGEST or max(openings, items) > _MOST_OPENINGS:
                raise InputError(_NESTED)
            content = _READ_ONLY[syntax][1](text) if syntax in _READ_ONLY else plain(_TREES[syntax](text)[1])
            return Document(str(name), text, syntax, content)
        except RecursionError:
            raise InputError(_NESTED) from None
        except InputError as error:
            if guessed and str(error) == _yaml.DAMAGED:  # not known, rather than damaged: nothing is found in it
                return Document(str(name), text, syntax, {})
            raise


def read_document(path: Path, syntax: Syntax | None = None, *, lines: bool = True) -> Document:
    """The text of a file, parsed; `syntax` and `lines` as of `document`. That of a binary file is what it would be as
    JSON."""
    binary = binary_text(path)
    if binary is not None:
        return document(path, binary, Syntax.JSON)
    return document(path, read_text(path), syntax, lines=lines)


def _syntax_of(text: str, lines: bool) -> Syntax:
    start = text.lstrip()[:1]
    for syntax, (looks, _) in _READ_ONLY.items():
        if start not in "{<" and looks(text):
            return syntax
    if _PYTHON.match(text.lstrip()):
        return Syntax.YAML
    if start == "{" or (start == "[" and not _SECTION.search(text)):
        return Syntax.JSON
    if start == "<":
        return Syntax.XML
    if not lines or text.startswith("%YAML"):
        return Syntax.YAML
    if _EQUALS.search(text):
        return Syntax.EQUALS
    return Syntax.COLONS if _COLONS.search(text) else Syntax.YAML
