"""Numbers that a person can read."""

import re

import pytest
from hypothesis import given, strategies as st

from stereorecal.report.number_text import change, depths


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


def test_depths():
    assert depths({5: 8.31, 30: 210.0, 100: float("inf")}) == (
        "+8.3 % at 5 B, 3.1 times as far at 30 B, beyond infinity at 100 B"
    )
