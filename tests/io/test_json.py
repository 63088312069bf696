"""JSON: one text for each content, read back as it was; every bad number, text or nesting is one sentence."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused

from stereorecal import InputError
from stereorecal.io import json_data, json_line, json_text, parse_json, read_json, save_rig, write_json
from stereorecal.synthetic import default_rig

leaves = st.none() | st.booleans() | st.integers(-(10**308), 10**308) | st.floats() | st.text(max_size=5)
nested = st.recursive(
    leaves, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3)
)


@given(nested)
def test_what_is_written_is_read_back(content):
    text = json_text(content)
    assert text.endswith("\n")
    assert parse_json(text) == json_data(content)
    assert parse_json(json_line(content)) == json_data(content)
    assert json_line(content).count("\n") == 1


def test_the_text():
    content = {"b": np.array([1.5, math.nan]), "a": (np.float32(0.5), math.inf), 3: np.bool_(True)}
    assert json_text(content) == '{\n "b": [\n  1.5,\n  null\n ],\n "a": [\n  0.5,\n  null\n ],\n "3": true\n}\n'
    assert json_text({"b": {"d": 1, "c": 2}, "a": 3}, sort_keys=True).split() == [
        "{", '"a":', "3,", '"b":', "{", '"c":', "2,", '"d":', "1", "}", "}",
    ]  # fmt: skip
    assert json_line({"b": [math.nan, 1]}) == '{"b": [null, 1]}\n'


def test_files(tmp_path: Path):
    path = tmp_path / "a.json"
    write_json(str(path), {"boat": "Čoln", "x": math.nan})
    assert read_json(path) == {"boat": "Čoln", "x": None}
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())  # a byte order mark
    assert read_json(str(path)) == {"boat": "Čoln", "x": None}
    refused(lambda: write_json(tmp_path / "missing" / "a.json", {}), "cannot be written")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the file is empty"),
        (b"\xff\xfe{", "UTF-8"),
        (b'{"a": 1} x', "not valid JSON, or truncated"),
        (b'{"b": [{"a": 1, "a": 2}]}', "the key 'a' occurs twice"),
        (b"\x1f\x8b\x08\x00", "is compressed; unpack it"),
        (b"[01]", "not valid JSON"),
        (b'{"a": NaN}', "a contains NaN; put a finite number"),
        (b'{"a": {"b": [1, {"c": [-Infinity]}]}}', "c contains -Infinity; put a finite number"),
        (b"[1e999]", "the file contains Infinity; put a finite number"),
        (b'{"a": 1' + b"0" * 309 + b"}", "a contains Infinity; put a finite number"),
        (b'{"a": -' + b"9" * 5000 + b"}", "a contains -Infinity"),
        (b"[" * 102 + b"]" * 102, "nests more than 100 levels"),
        (b"[" * 100_000 + b"]" * 100_000, "nests more than 100 levels"),
        (b'{"a":' * 100_000, "nests more than 100 levels"),
    ],
)
def test_files_that_are_refused(tmp_path: Path, content: bytes, words: str):
    path = tmp_path / "a.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words) as error:
        read_json(path)
    assert str(error.value).startswith(f"{path}: ")
    assert len(str(error.value)) < 300
    refused(lambda: read_json(path))


def test_a_missing_file(tmp_path: Path):
    refused(lambda: read_json(tmp_path / "a.json"), "no such file")


@given(st.text() | st.text(st.sampled_from('[]{}",:-+.0123456789eENaInfity \n\\u')))
def test_any_text_is_read_or_refused(text: str):
    try:
        content = parse_json(text)
    except InputError:
        return
    assert content == json.loads(text)
    json.dumps(content, allow_nan=False)


@given(st.integers(1, 40))
def test_a_truncated_text_is_said_to_be_one(cut: int):
    text = '{"K": [1.5, 2], "größe": {"a": null, "b": "c"}}'[:cut]
    refused(lambda: parse_json(text), "not valid JSON, or truncated")


@pytest.mark.parametrize("number", ["1e308", "-0.0", "5e-324", "1e-999", "9" * 308, "1E5"])
def test_extreme_numbers_that_are_fine(number: str):
    assert parse_json(number) == json.loads(number)


ITSELF: dict = {}
ITSELF["self"] = ITSELF
DEEP: list = []
for _ in range(100_000):
    DEEP = [DEEP]


@pytest.mark.parametrize(
    "value", [math.nan, -math.inf, np.zeros(2), {1, 2}, 10**5000, b"x", ITSELF, DEEP], ids=lambda _: ""
)
def test_a_calibration_is_refused_rather_than_changed(value, tmp_path: Path):
    with pytest.raises(InputError, match="cannot be written as JSON"):
        save_rig(default_rig(), tmp_path / "a.json", {"value": [value]})
