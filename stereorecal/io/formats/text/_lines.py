"""Lines `key: values` (KITTI) and `key=values` (Middlebury)."""

import re
from functools import partial
from typing import Any

from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Values, leaves, number_text


def _parsed_colons(text: str) -> dict[str, Any]:
    lines = (line.partition(":") for line in text.splitlines())
    return {key.strip(): [number_or_word(word) for word in values.split()] for key, colon, values in lines if colon}


def _parsed_equals(text: str) -> dict[str, Any]:
    lines = (line.partition("=") for line in text.splitlines())
    return {key.strip(): _matrix_rows(values) for key, _, values in lines}


def _matrix_rows(values: str) -> list[list[float | str]]:
    """The rows of a matrix `[a b; c d]`; a number is a matrix of one."""
    return [[number_or_word(word) for word in row.split()] for row in values.strip(" []").split(";")]


def _changed(sign: str, text: str, values: Values) -> str:
    """The text with other values; every line that is not named stays as it is."""
    for (key,), value in values.items():
        line = re.compile(rf"^(\s*{re.escape(str(key))}\s*{sign}[ \t]*)[^\r\n]*", re.MULTILINE)
        text = line.sub(lambda found, value=value: found[1] + _value_text(value), text)
    return text


def _value_text(value: Any) -> str:
    if isinstance(value, list) and isinstance(value[0], list):
        return "[" + "; ".join(" ".join(map(number_text, row)) for row in value) + "]"
    return " ".join(map(number_text, leaves(value)))


parsed_colons, changed_colons = _parsed_colons, partial(_changed, ":")
parsed_equals, changed_equals = _parsed_equals, partial(_changed, "=")
