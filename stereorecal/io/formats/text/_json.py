"""JSON: parsed, and written again with the same indentation."""

import copy
import json
import re
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._json import parse_json
from stereorecal.io.formats.text._values import Values


def parsed(text: str) -> dict[str, Any]:
    """The keys and values of a JSON object.

    Raises:
        InputError: if it is none.
    """
    content = parse_json(text)
    if not isinstance(content, dict):
        raise InputError("there is no JSON object of named values in the file; correct it.")
    return content


def changed(text: str, values: Values) -> str:
    """The text with other values: the same keys in the same order, and the same indentation."""
    content: Any = copy.deepcopy(parsed(text))
    for keys, value in values.items():
        place = content
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = value
    found = re.search(r"\n([ \t]+)\S", text)
    separators = None if found or ", " in text else (",", ":")
    indent = None if found is None else found[1]
    end = "\n" if text.endswith("\n") else ""
    return json.dumps(content, indent=indent, separators=separators, allow_nan=False, ensure_ascii=text.isascii()) + end
