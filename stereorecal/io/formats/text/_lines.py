"""Lines `key: values` (KITTI) and `key=values` (Middlebury)."""

import re
from functools import partial
from typing import Any

from stereorecal.io.formats._numbers import number_or_word
from stereorecal.io.formats.text._splice import Values, leaves, number_text, spliced


def parsed_colons(text: str) -> dict[str, Any]:
    """The numbers and words of each line by its key."""
    lines = (line.partition(":") for line in text.splitlines())
    return {key.strip(): [number_or_word(word) for word in values.split()] for key, colon, values in lines if colon}


def parsed_equals(text: str) -> dict[str, Any]:
    """The rows of a matrix `[a b; c d]` by its key; a number is a matrix of one."""
    lines = (line.partition("=") for line in text.splitlines())
    return {
        key.strip(): [[number_or_word(word) for word in row.split()] for row in values.strip(" []").split(";")]
        for key, _, values in lines
    }


def _with_values(sign: str, text: str, values: Values) -> str:
    """The text with other values; every line that is not named stays as it is."""
    edits = []
    for (key,), value in values.items():
        lines = re.finditer(rf"^\s*{re.escape(str(key))}\s*{sign}[ \t]*([^\r\n]*)", text, re.MULTILINE)
        edits += [(*line.span(1), _value_text(value)) for line in lines]
    return spliced(text, edits)


def _value_text(value: Any) -> str:
    if isinstance(value, list) and isinstance(value[0], list):
        return "[" + "; ".join(" ".join(map(number_text, row)) for row in value) + "]"
    return " ".join(map(number_text, leaves(value)))


colons_with_values, equals_with_values = partial(_with_values, ":"), partial(_with_values, "=")
