"""The reader of numbers: finite arrays of the right shape, or one sentence that names the key."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from parts_of_repairs import image_size, number_or_word, numbers, value
from refusals import refused

from stereorecal import InputError

SHAPES = [(), (2,), (3,), (4,), (9,), (-1,), (3, 3), (4, 4)]
leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3) | st.just(10**400)
nested = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=1), inner, max_size=1),
    max_leaves=10,
)


def read_or_refused(read: Callable[[], Any], key: str) -> Any:
    """What is read; None if it is refused in one sentence about the key."""
    message, found = "", None
    try:
        found = read()
    except InputError as error:
        message = str(error)
    assert not message or (message.startswith(f"{key} ") and message.endswith(".") and "\n" not in message)
    return found


def nest(content: Any, levels: int) -> Any:
    for _ in range(levels):
        content = [content]
    return content


@given(nested, st.sampled_from(SHAPES))
def test_any_value_is_read_or_refused(content, shape: tuple[int, ...]):
    found = read_or_refused(lambda: numbers({"K": content}, "K", shape), "K")
    if found is not None:
        assert found.dtype == np.float64
        assert np.isfinite(found).all()
        assert found.shape == shape or (shape == (-1,) and found.ndim == 1)
    size = read_or_refused(lambda: image_size({"size": content}, "size"), "size")
    assert size is None or np.min(size) >= 1


@given(st.lists(st.lists(st.floats(-1e300, 1e300), min_size=3, max_size=3), min_size=3, max_size=3))
def test_a_matrix_is_itself_however_it_is_wrapped(rows):
    for levels in range(3):
        np.testing.assert_array_equal(numbers({"K": nest(rows, levels)}, "K", (3, 3)), rows)


@pytest.mark.parametrize(
    ("content", "shape", "words"),
    [
        (True, (), "K is not an array of numbers"),
        ([1.0, False], (2,), "K is not an array of numbers"),
        (["1.5", 2], (2,), "K is not an array of numbers"),
        ([[1, 2], [3]], (2, 2), "K is not an array of numbers"),
        ([1, [2]], (2,), "K is not an array of numbers"),
        ({"rows": 1}, (1,), "K is not an array of numbers"),
        (nest(1.0, 5), (), "K is not an array of numbers"),
        (nest(1.0, 100_000), (), "K is not an array of numbers"),
        ([1, None], (2,), "K contains null"),
        ([1, -math.inf], (2,), "K contains NaN or infinite"),
        ([1, -(10**5000)], (2,), "K contains NaN or infinite"),
        ([1, 2, 3], (2,), "K must hold 2 numbers, not 3"),
        ([], (2,), "K must hold 2 numbers, not 0"),
        ([[1, 2], [3, 4]], (-1,), "K must hold a list of numbers, not 2x2"),
        ([1, 2], (), "K must hold one number, not 2"),
        (1, (3, 3), "K must hold 3x3 numbers, not one"),
    ],
    ids=itertools.count(),  # such integers have no text
)
def test_what_is_refused(content, shape: tuple[int, ...], words: str):
    refused(lambda: numbers({"K": content}, "K", shape), words)


def test_rows_may_be_one_list():
    np.testing.assert_array_equal(numbers({"K": [1, 2, 3, 4, 5, 6]}, "K", (2, 3)), [[1, 2, 3], [4, 5, 6]])
    stated = {"rows": 3, "cols": 3, "data": [1, 2, 3, 4, 5, 6]}  # which says otherwise
    refused(lambda: numbers({"K": stated}, "K", (2, 3)), "K must hold 2x3 numbers, not 6")


def test_a_missing_key():
    for read in (value, image_size, lambda content, key: numbers(content, key, (3,))):
        refused(lambda read=read: read({"k": 1}, "K"), "the key 'K' is missing")


@pytest.mark.parametrize("size", [0, -1, 24.5, 1e6 + 1e5, 1e300])
def test_sizes_that_no_image_has(size: float):
    words = "but an image size is a whole number of pixels"
    refused(lambda: image_size({"width": size, "height": 1}, "width", "height"), "width is ", words)
    refused(lambda: image_size({"size": [24, size]}, "size"), "size is ", words)


def test_sizes():
    assert image_size({"size": [[24.0], [16]]}, "size") == (24, 16)
    assert image_size({"width": [[1 << 20]], "height": 1}, "width", "height") == (1 << 20, 1)


@pytest.mark.parametrize(
    ("word", "expected"),
    [("1.5", 1.5), ("-1e-3", -0.001), (".5", 0.5), ("1_0", "1_0"), ("٣", "٣"), ("0x10", "0x10"), ("09-Jan", "09-Jan")],
)
def test_words(word: str, expected: float | str):
    assert number_or_word(word) == expected


@pytest.mark.parametrize("word", ["1e999", "-inf", "nan", "9" * 5000])
def test_words_of_no_finite_number(word: str):
    refused(lambda: numbers({"K": [number_or_word(word)]}, "K", (-1,)), "K contains NaN or infinite")
