"""Texts of lines: `key: values` (KITTI) and `key=values` (Middlebury), and where the values stand; and those that are
read and not written: numbers alone, the ost.txt that ROS' camera_calibration writes beside its YAML files, INI files,
and what rs-enumerate-devices prints."""

import re
from typing import Any

from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats.text._nodes import DOCUMENTS, Node, number_or_word, words

_ROW = re.compile(r"[^;\[\]]+")
_SECTION = re.compile(r"\[([^\]]+)\]")
_INTRINSIC = re.compile(r'\s*Intrinsic of "([^"]+)"[\s/]*\d+x\d+[\s/]*(.*)')
_EXTRINSIC = re.compile(r'\s*Extrinsic from "([^"]+)"\s+To\s+"([^"]+)"')


def colons(text: str) -> tuple[str, Node]:
    """The text, and the numbers and words of each line by its key."""
    return text, Node({key: words(text, *place) for key, place in _lines(text, ":").items()}, 0, len(text))


def equals(text: str) -> tuple[str, Node]:
    """The text, and the rows of a matrix `[a b; c d]` by its key; a number is a matrix of one."""
    rows: dict[str, Node] = {}
    for key, (start, end) in _lines(text, "=").items():
        inside = [row.span() for row in _ROW.finditer(text, start, end)] or [(start, end)]
        rows[key] = Node([words(text, *place) for place in inside], start, end, between=" ")
    return text, Node(rows, 0, len(text))


def _lines(text: str, sign: str) -> dict[str, tuple[int, int]]:
    """Where what is right of the sign stands in each line, by what is left of it."""
    found, at = dict[str, tuple[int, int]](), 0
    for line in text.splitlines(keepends=True):
        key, given, values = line.partition(sign)
        if given:
            end = at + len(line.rstrip())
            found[key.strip()] = min(end, at + len(line) - len(values.lstrip())), end
        at += len(line)
    return found


def numbers_in(text: str) -> list[list[float]] | None:
    """The numbers of each line; None if there is anything else but comments."""
    rows = []
    for line in text.splitlines():
        stated = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        row = [number for word in stated if not isinstance(number := number_or_word(word), str)]
        if len(row) < len(stated):
            return None
        rows += [row] if row else []
    return rows or None


def parsed_numbers(text: str) -> dict[str, Any]:
    """The lines of numbers, under the key `numbers`."""
    found = numbers_in(text) or []
    return {"numbers": [x for row in found for x in row] if len(found) == 1 else found}


# A line of its own, as no other text has it.
looks_like_ost = re.compile(r"^camera matrix[ \t\r]*$", re.MULTILINE).search


def parsed_ost(text: str) -> dict[str, Any]:
    """The cameras of an ost.txt, as the documents of a YAML text would say them: the rows of numbers of a section by
    title, which stands on a line of its own above them, with those of the section of the image."""
    sections: list[tuple[str, dict[str, Any]]] = []
    title = ""
    for line in (line.partition("#")[0].strip() for line in text.splitlines()):
        section, row = _SECTION.fullmatch(line), numbers_in(line)
        if section:
            sections.append((section[1], {}))
        elif row is None:
            title = line.replace(" ", "_") or title
        elif sections:
            sections[-1][1].setdefault(title, []).extend(row)
    cameras = without_duplicates(sections)
    image = cameras.pop("image", {})
    return {DOCUMENTS: [{**image, **camera, "camera_name": name} for name, camera in cameras.items()]}


looks_like_ini = re.compile(
    r"^\[[A-Za-z_][^\]\n]*\][ \t]*\r?\n(?:[ \t]*(?:[#;].*)?\r?\n)*[ \t]*\w+[ \t]*=", re.MULTILINE
).search


def parsed_ini(text: str) -> dict[str, Any]:
    """The values of an INI file by section and key, in capitals, as its readers do not tell them apart."""
    sections: list[tuple[str, list[tuple[str, Any]]]] = []
    for line in (re.split(r"[#;]", line)[0].strip() for line in text.splitlines()):
        title, (key, sign, value) = _SECTION.fullmatch(line), line.partition("=")
        if title:
            sections.append((title[1].strip().upper(), []))
        elif sign and sections:
            sections[-1][1].append((key.strip().upper(), number_or_word(value.strip())))
    return without_duplicates([(title, without_duplicates(values)) for title, values in sections])


looks_like_devices = re.compile(r'^\s*(?:In|Ex)trinsic (?:of|from) "', re.MULTILINE).search


def parsed_devices(text: str) -> dict[str, Any]:
    """`intrinsics`: a list of maps of what is printed of each mode of each camera; `extrinsics`: a list of maps with
    the names of two cameras and all numbers of the motion from the one to the other."""
    found: dict[str, Any] = {"intrinsics": [], "extrinsics": []}
    numbers: list[Any] | None = None
    for line in text.splitlines():
        intrinsic, extrinsic = _INTRINSIC.match(line), _EXTRINSIC.match(line)
        key, sign, rest = line.partition(":")
        if intrinsic:
            found["intrinsics"].append({"name": intrinsic[1], "kinds": intrinsic[2].strip()})
            numbers = None
        elif extrinsic:
            numbers = []
            found["extrinsics"].append({"from": extrinsic[1], "to": extrinsic[2], "numbers": numbers})
        elif numbers is not None:
            values = [number_or_word(word) for word in (rest if sign else line).split()]
            numbers.extend(values if len(numbers) < 12 else [])
        elif sign and found["intrinsics"]:
            values = [number_or_word(word) for word in rest.split()]
            found["intrinsics"][-1].setdefault(key.strip(), values[0] if len(values) == 1 else values)
    return found
