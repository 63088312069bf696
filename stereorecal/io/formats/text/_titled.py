"""Texts whose lines stand under titles: INI files, and what rs-enumerate-devices prints."""

import re
from typing import Any

from stereorecal.io._strict_json import without_duplicates
from stereorecal.io.formats._numbers import number_or_word

_TITLE = re.compile(r"\[([^\]\n]+)\]\s*")
_INTRINSIC = re.compile(r'\s*Intrinsic of "([^"]+)"[\s/]*(\d+)x(\d+)[\s/]*(.*)')
_EXTRINSIC = re.compile(r'\s*Extrinsic from "([^"]+)"\s+To\s+"([^"]+)"')


def parsed_ini(text: str) -> dict[str, Any]:
    """The values of an INI file by section and key, in capitals, as its readers do not tell them apart.

    Raises:
        InputError: if a section or a key occurs twice with different values.
    """
    sections: list[tuple[str, list[tuple[str, Any]]]] = []
    for line in (re.split(r"[#;]", line)[0].strip() for line in text.splitlines()):
        title, (key, sign, value) = _TITLE.fullmatch(line), line.partition("=")
        if title:
            sections.append((title[1].strip().upper(), []))
        elif sign and sections:
            sections[-1][1].append((key.strip().upper(), number_or_word(value.strip())))
    return without_duplicates([(title, without_duplicates(values)) for title, values in sections])


def parsed_devices(text: str) -> dict[str, Any]:
    """`intrinsics`: a list of maps of what is printed of each mode of each camera; `extrinsics`: a list of maps with
    the names of two cameras and all numbers of the motion from the one to the other."""
    found: dict[str, Any] = {"intrinsics": [], "extrinsics": []}
    numbers: list[Any] | None = None
    for line in text.splitlines():
        intrinsic, extrinsic = _INTRINSIC.match(line), _EXTRINSIC.match(line)
        key, sign, words = line.partition(":")
        if intrinsic:
            name, _, _, kinds = intrinsic.groups()
            found["intrinsics"].append({"name": name, "kinds": kinds.strip()})
            numbers = None
        elif extrinsic:
            numbers = []
            found["extrinsics"].append({"from": extrinsic[1], "to": extrinsic[2], "numbers": numbers})
        elif numbers is not None:
            values = [number_or_word(word) for word in (words if sign else line).split()]
            numbers.extend(values if len(numbers) < 12 else [])
        elif sign and found["intrinsics"]:
            values = [number_or_word(word) for word in words.split()]
            found["intrinsics"][-1].setdefault(key.strip(), values[0] if len(values) == 1 else values)
    return found
