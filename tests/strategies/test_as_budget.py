"""What is accepted for a budget: nothing, a number of units, or a Budget."""

from fractions import Fraction

import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.strategies import Budget, as_budget


def test_none_is_no_limit_and_a_budget_is_itself():
    assert as_budget(None) == Budget() == Budget(None, None)
    budget = Budget(evaluations=3.5, seconds=2)
    assert as_budget(budget) is budget


@pytest.mark.parametrize("number", [500, 500.0, np.int64(500), np.float32(500)])
def test_a_number_limits_the_evaluations(number):
    found = as_budget(number)
    assert found == Budget(evaluations=float(number))
    assert found.seconds is None
    assert type(found.evaluations) in (int, float)


@pytest.mark.parametrize(
    "other",
    [
        "9" * 100_000,
        True,
        np.bool_(True),
        1j,
        Fraction(1, 2),
        (500, 20),
        {"evaluations": 500},
        np.array(500.0),
        Budget,
    ],
    ids=lambda value: type(value).__name__,
)
def test_anything_else_is_refused_and_the_right_call_is_shown(other):
    with pytest.raises(InputError, match=r"^budget is 'ten'; give a number"):
        as_budget("ten")
    with pytest.raises(InputError) as caught:
        as_budget(other)
    message = str(caught.value)
    assert message.startswith("budget is ")
    assert len(message) < 250
    assert message.endswith("; give a number of units, such as budget=500, or sr.Budget(evaluations=500, seconds=20).")


@pytest.mark.parametrize("number", [0, -1, -float("inf"), 10**400, np.float32("nan")])
def test_numbers_that_make_no_sense(number):
    with pytest.raises(InputError, match=r"makes no sense; give a positive number, or None for no limit") as caught:
        as_budget(number)
    assert len(str(caught.value)) < 200
