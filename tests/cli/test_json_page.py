"""The page on JSON, held against what commands write: no key that it does not list, and none that nobody writes."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.recalibration import RangesSeen

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "json.md"
INTRINSICS = sr.Intrinsics(  # freeing them takes longer than a test may
    sr.IntrinsicsOutcome.REFINED, ("k1",), ("",), np.zeros(1), np.ones(1), (), 0.2, 0.1, 0.2, 0.1, 0.9, 0.1
)
COUNT = ("--schedule", "count", "--scale", 0.5, "--budget", 40)


def listed() -> dict[str, set[str]]:
    """Keys by the heading that they stand under."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(), flags=re.MULTILINE)[1:]
    return {
        head.strip(" `"): {
            key for row in re.findall(r"^\| (`.*?) \|", body, re.MULTILINE) for key in row[1:-1].split("`, `")
        }
        for head, body in zip(parts[::2], parts[1::2], strict=True)
    }


def paths(content: Any, at: str = "") -> Iterator[str]:
    """Of all that is neither an object nor a list of objects."""
    if isinstance(content, dict) and content:
        for key, value in content.items():
            yield from paths(value, f"{at}.{key}" if at else key)
    elif isinstance(content, list) and content and isinstance(content[0], dict):
        for value in content:
            yield from paths(value, f"{at}[]")
    else:
        yield at


def matched(key: str, path: str) -> bool:
    return re.fullmatch(re.escape(key).replace(r"\*", r"[^.]+"), path) is not None


@pytest.fixture(scope="module")
def pages() -> dict[str, set[str]]:
    return listed()


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("schema", ["solution", "health", "difference", "compare"])
def test_what_is_written_and_what_is_listed(command, schema: str, pages, clean_scene, drifted_scene, tmp_path: Path):
    words = {
        "solution": ("recalibrate", drifted_scene),
        "health": ("score", drifted_scene),
        "difference": ("diff", clean_scene, drifted_scene),
        "compare": ("compare", "--scene", drifted_scene, "--draws", 1, *COUNT),
    }[schema]
    target = tmp_path / "out.json"
    command(*words, "--json", target, "--quiet")
    content = json.loads(target.read_text())
    assert content["schema"] == f"stereorecal.{schema}/1"
    if schema == "solution":
        assert content["repairs"][0]["intrinsics"] is None
        assert content["repairs"][0]["ranges"] is None
        content["repairs"][0]["intrinsics"] = INTRINSICS.as_dict()
        content["repairs"][0]["ranges"] = RangesSeen(5, 4, 1).as_dict()
    keys = pages["All schemas"] | pages[content["schema"]]
    written = set(paths(content))
    assert {path for path in written if not any(matched(key, path) for key in keys)} == set()
    assert {key for key in keys if not any(matched(key, path) for path in written)} == set()


def test_the_page_is_read(pages):
    """Every heading, more than one key in a row, and what would not be found."""
    assert set(pages) == {"All schemas"} | {
        f"stereorecal.{n}/1" for n in ("solution", "health", "difference", "compare")
    }
    assert {"before", "after"} <= pages["stereorecal.difference/1"]
    assert list(paths({"a": {"b": 1, "c": [{"d": None}, {"e": []}]}, "f": {}})) == ["a.b", "a.c[].d", "a.c[].e", "f"]
    assert matched("a[].*", "a[].b")
    assert not matched("a[].*", "a[].b.c")
    assert not matched("a.b", "a.bc")
