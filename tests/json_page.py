"""The page on JSON, read by tests, and held against what is written."""

import re
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "json.md"


def expanded(key: str) -> Iterator[str]:
    """The keys that braces stand for: `a.b` and `a.c` of `a.{b,c}`."""
    parts = re.split(r"\{(.*?)\}", key)  # every second one was in braces
    return map("".join, product(*(part.split(",") if index % 2 else [part] for index, part in enumerate(parts))))


def listed() -> dict[str, set[str]]:
    """The keys by the heading that they stand under."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(), flags=re.MULTILINE)[1:]
    return {
        head.strip(" `"): {
            key
            for row in re.findall(r"^\| (`.*?) \|", body, re.MULTILINE)
            for short in row[1:-1].split("`, `")
            for key in expanded(short)
        }
        for head, body in zip(parts[::2], parts[1::2], strict=True)
    }


def paths(content: Any, at: str = "") -> Iterator[str]:
    """Paths of all values that are neither objects nor lists of objects; a name with a dot (`left.f`) is one part."""
    if isinstance(content, dict) and content:
        for key, value in content.items():
            yield from paths(value, f"{at}.{key.replace('.', '_')}" if at else key)
    elif isinstance(content, list) and content and isinstance(content[0], dict):
        for value in content:
            yield from paths(value, f"{at}[]")
    else:
        yield at


def matched(key: str, path: str) -> bool:
    return re.fullmatch(re.escape(key).replace(r"\*", r"[^.]+"), path) is not None


def differences(contents: list[dict[str, Any]]) -> tuple[set[str], set[str]]:
    """The paths that are written under a schema but not listed, and the keys that are listed but never written."""
    pages = listed()
    keys = pages["All schemas"] | pages[contents[0]["schema"]]
    written = {path for content in contents for path in paths(content)}
    unlisted = {path for path in written if not any(matched(key, path) for key in keys)}
    return unlisted, {key for key in keys if not any(matched(key, path) for path in written)}
