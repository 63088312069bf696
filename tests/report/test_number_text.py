"""Numbers and lists that a person can read."""

import re

import pytest
from hypothesis import given, strategies as st

from stereorecal.report.number_text import MOST, between, change, distance, number, short_list


@pytest.mark.parametrize(
    ("percent", "text"),
    [
        (0.0, "+0.0 %"),
        (-0.001, "+0.0 %"),
        (-72.04, "-72.0 %"),
        (-99.9, "-99.9 %"),
        (100.0, "+100.0 %"),
        (100.1, "2.0 times as far"),
        (240.0, "3.4 times as far"),
        (899.0, "10 times as far"),
        (1573.8, "17 times as far"),
        (99_900.0, "1 000 times as far"),
        (float("inf"), "beyond infinity"),
        (float("nan"), "unknown"),
    ],
)
def test_changes(percent: float, text: str):
    assert change(percent, "far") == text


@given(st.floats(-100, 1e9))
def test_no_percentage_beyond_a_hundred(percent: float):
    (number,) = re.findall(r"[\d .]*\d", change(percent, "long"))
    value = float(number.replace(" ", ""))
    assert value <= 100.0 if "%" in change(percent, "long") else value >= 2.0


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.012, 0.064, "12 to 64 mm too far"),
        (-0.17, -0.144, "14 to 17 cm too near"),
        (-0.0031, 0.0069, "-3.1 to +6.9 mm"),
        (-1.23, 1.68, "-1.2 to +1.7 m"),
        (-0.2, -0.2, "20 cm too near"),
        (0.0, 0.0, "0 mm"),
        (1.0, float("inf"), "1.0 m too far to beyond infinity"),
        (float("inf"), float("inf"), "beyond infinity"),
        (31.0, 4300.0, "31 to 4 300 m too far"),
        (float("nan"), 1.0, "unknown"),
    ],
)
def test_errors_of_depth(low: float, high: float, text: str):
    assert between(low, high) == text


@given(st.floats(-1e4, 1e4), st.floats(0.0, 1e4))
def test_an_interval_that_holds_0_has_signs_and_others_a_side(low: float, width: float):
    text = between(low, low + width)
    holds = low <= 0.0 <= low + width or max(abs(low), abs(low + width)) < 5e-5
    assert holds == ("too" not in text)
    assert "-" not in text or holds


@pytest.mark.parametrize(("metres", "text"), [(0.0849, "85 mm"), (0.4, "40 cm"), (2.53, "2.5 m"), (53.0, "53 m")])
def test_distances(metres: float, text: str):
    assert distance(metres) == text
    assert between(metres, metres) == f"{text} too far"


def test_what_is_nothing_has_no_sign():
    assert number(-0.0004, 3) == "0.000"


@given(st.lists(st.text("abcdef", min_size=1), max_size=30))
def test_nothing_is_lost_but_counted(names: list[str]):
    said = short_list(names, "; ").split("; ") if names else []
    assert len(said) == min(len(names), MOST)
    shown = [*said] if len(names) <= MOST else said[:-1]
    assert shown == names[: len(shown)]
    if len(names) > MOST:
        assert said[-1] == f"{len(names) - len(shown)} more"
