"""Damaged files are read or refused in one sentence. `tests/benchmarks/fuzz.py` does so for hours."""

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from damage import damaged
from hypothesis import given, strategies as st
from parts_of_repairs import Syntax, document
from refusals import refused

from stereorecal import InputError
from stereorecal.io import load_log, load_pair, load_ranges, load_rig, save_rig
from stereorecal.synthetic import default_rig

DEEP = 200_000
FORMATS = {
    "stereorecal": "a.json",
    "opencv": "a.yaml",
    "kalibr": "a.yaml",
    "basalt": "a.json",
    "depthai": "a.json",
    "boofcv": "a.yaml",
    "kitti-raw": "a.txt",
}
NESTED = {
    "a.json": ["[" * DEEP, '{"K_left":' + "[" * DEEP + "]" * DEEP + "}", '{"cameraData":' * DEEP],
    "a.yaml": [
        "[" * DEEP,
        "{a: " * DEEP,
        "%YAML:1.0\n---\nM1: " + "[" * DEEP + "1" + "]" * DEEP,
        "%YAML:1.0\n---\nM1: " + "[" * 1500 + "1" + "]" * 1500,  # few enough brackets, too deep for Python
        "- " * DEEP,
        "? " * DEEP,
        "\n".join(" " * i + "a:" for i in range(2000)),
    ],
    "a.xml": ["<a>" * DEEP, '<?xml version="1.0"?>\n<opencv_storage>' + "<a>" * DEEP, "<a>" * 900 + "</a>" * 900],
}


@pytest.mark.parametrize(("name", "text"), [(name, text) for name, texts in NESTED.items() for text in texts])
def test_nested_200_000_deep(tmp_path: Path, name: str, text: str):
    path = tmp_path / name
    path.write_text(text)
    words = "too deeply nested|nests more than 100 levels|not a YAML file|not valid JSON|the format is unknown"
    with pytest.raises(InputError, match=words) as error:
        load_rig(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["mission.json", "calib.json"])
def test_nested_files_beside_images(tmp_path: Path, name: str):
    rig = default_rig()
    (tmp_path / "calibrations").mkdir()
    save_rig(rig, tmp_path / "calibrations" / "2026-01-01.json")
    sequence = tmp_path / "sequences" / "2026-01-01"
    sequence.mkdir(parents=True)
    (sequence / "mission.json").write_text('{"a":' * DEEP)
    if name == "calib.json":
        (tmp_path / "calibrations" / "2026-01-01.json").write_text("[" * DEEP)
    refused(lambda: load_log(tmp_path), "nests more than 100 levels")


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The same rig in several formats."""
    folder = tmp_path_factory.mktemp("good")
    rig = default_rig()
    left, right = (replace(camera, distortion=np.array([-0.2, 0.1, 1e-3, 1e-3])) for camera in (rig.left, rig.right))
    rig = replace(rig, left=left, right=right)
    for format, name in FORMATS.items():
        (folder / format).mkdir()
        save_rig(rig, folder / format / name, format=format)
    return {format: (folder / format / name).read_bytes() for format, name in FORMATS.items()}


def refused_or_read(read, *paths: Path) -> None:
    said = ""
    try:
        read(*paths)
    except InputError as error:
        said = str(error)
    assert "\n" not in said


@pytest.mark.filterwarnings("ignore::stereorecal._errors.CalibrationWarning")
@given(seed=st.integers(0, 2**32 - 1), format=st.sampled_from(sorted(FORMATS)))
def test_damaged_calibrations(good, tmp_path_factory, seed: int, format: str):
    path = tmp_path_factory.mktemp("bad") / FORMATS[format]
    path.write_bytes(damaged(good[format], np.random.default_rng(seed)))
    refused_or_read(load_rig, path)


def places_in(content: Any, place: tuple = ()) -> Iterator[tuple]:
    """The keys of every value."""
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for key, inside in items:
        yield (*place, key)
        yield from places_in(inside, (*place, key))


OTHERS = [None, 5, "word", "", [], [1, 2], [[1], [2, 3]], {}, {"a": 1}, {"rows": "a", "cols": [], "data": 3}]


@pytest.mark.filterwarnings("ignore::stereorecal._errors.CalibrationWarning")
@pytest.mark.parametrize("format", sorted({*FORMATS} - {"kitti-raw", "opencv"}))
@given(data=st.data())
def test_values_of_other_kinds(good, tmp_path_factory, format: str, data: st.DataObject):
    """A list where there should be keys, a word for a number, numbers without a key: nothing escapes but a sentence."""
    content = yaml.safe_load(good[format])  # of which JSON is a part
    *above, last = data.draw(st.sampled_from(list(places_in(content))))
    reduce(lambda inside, key: inside[key], above, content)[last] = data.draw(st.sampled_from(OTHERS))
    path = tmp_path_factory.mktemp("kinds") / FORMATS[format]
    path.write_text(json.dumps(content))

    def read_and_write(path: Path) -> None:
        rig = load_rig(path, format=format)
        save_rig(rig.with_extrinsics(rig.extrinsics + 1e-3), path, overwrite=True)

    refused_or_read(read_and_write, path)


SIGNS = "{}[]<>/=:,-&*!|%#?\"' \n\t01.aö"


@pytest.mark.filterwarnings("ignore::stereorecal._errors.CalibrationWarning")
@given(
    data=st.binary(max_size=400) | st.text(SIGNS, max_size=400).map(str.encode), ending=st.sampled_from(sorted(NESTED))
)
def test_any_bytes(tmp_path_factory, data: bytes, ending: str):
    path = tmp_path_factory.mktemp("any") / ending
    path.write_bytes(data)
    refused_or_read(load_rig, path)


@given(seed=st.integers(0, 2**32 - 1), ending=st.sampled_from([".png", ".jpg", ".tif", ".bmp", ".pgm", ".webp"]))
def test_damaged_images(tmp_path_factory, seed: int, ending: str):
    random, folder = np.random.default_rng(seed), tmp_path_factory.mktemp("images")
    left, right = (folder / f"{side}{ending}" for side in ("left", "right"))
    for path in (left, right):
        path.write_bytes(cv2.imencode(ending, random.integers(0, 255, (24, 32), np.uint8))[1].tobytes())
    left.write_bytes(damaged(left.read_bytes(), random))
    refused_or_read(load_pair, left, right)


@given(seed=st.integers(0, 2**32 - 1))
def test_damaged_tables(tmp_path_factory, seed: int):
    path = tmp_path_factory.mktemp("tables") / "ranges.csv"
    table = b"pair,column,row,metres,sigma\n0,20,30,10.5,0.1\n0,21,30,inf,\n"
    path.write_bytes(damaged(table, np.random.default_rng(seed)))
    refused_or_read(load_ranges, path)


def test_a_cell_without_end(tmp_path: Path):
    path = tmp_path / "ranges.csv"
    path.write_text("pair,column,row,metres\n" + "1" * 200_000)
    refused(lambda: load_ranges(path), "not a table")


@pytest.mark.parametrize(
    ("format", "old", "new", "words"),
    [
        ("depthai", '"toCameraSocket": 2', '"toCameraSocket": ""', "do not lead to each other"),
        ("depthai", '"stereoRectificationData": {', '"stereoRectificationData": null, "a": {', ""),
    ],
)
def test_values_of_other_kinds_found(tmp_path: Path, good, format: str, old: str, new: str, words: str):
    path = tmp_path / FORMATS[format]
    assert old in good[format].decode()
    path.write_text(good[format].decode().replace(old, new, 1))

    def read_and_write() -> None:
        rig = load_rig(path, unit="m" if format == "boofcv" else None)
        save_rig(rig.with_extrinsics(rig.extrinsics * 1.01), path, overwrite=True)

    refused(read_and_write, words) if words else read_and_write()


def test_a_number_that_json_has_not():
    text = document("a.json", '{"T": [1.0]}', Syntax.JSON)
    refused(lambda: text.with_values({("T",): [float("inf")]}), "a.json: cannot be written as JSON")


def test_rows_of_different_lengths(tmp_path: Path, good):
    """Found by the fuzzer: a list in the place of one number of BoofCV's rotation."""
    path = tmp_path / "a.yaml"
    path.write_text(good["boofcv"].decode().replace("rotation: [", "rotation: [[1.0, 2.0], "))
    refused(lambda: load_rig(path), "rotation is not an array of numbers")
