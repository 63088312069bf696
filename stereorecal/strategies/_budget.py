"""Budgets: how much a strategy may spend."""

import reprlib
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._errors import InputError


@dataclass(frozen=True)
class Budget:
    """How much a strategy may spend; None means no limit.

    Attributes:
        evaluations: in units of one matcher run on one full-size frame. A candidate at image scale s over k frames
            costs k s² units.
        seconds: wall-clock time. A run that this limit cuts short is not repeatable.

    Raises:
        InputError: if a limit is not a finite positive number.
    """

    evaluations: float | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        for name, limit in (("evaluations", self.evaluations), ("seconds", self.seconds)):
            if limit is not None and not (_is_number(limit) and 0 < limit <= sys.float_info.max):
                raise InputError(
                    f"the budget of {reprlib.repr(limit)} {name} makes no sense; "
                    "give a positive number, or None for no limit."
                )


def as_budget(value: Any) -> Budget:
    """`value` as a Budget: None is no limit, a number is a limit on `evaluations`, a Budget is returned as it is.

    Raises:
        InputError: if it is anything else, or a number that is not positive.
    """
    if value is None:
        return Budget()
    if isinstance(value, Budget):
        return value
    if isinstance(value, np.generic):
        value = value.item()
    if _is_number(value):
        return Budget(evaluations=None if value == np.inf else value)
    raise InputError(
        f"budget is {reprlib.repr(value)}; give a number of units, such as budget=500, "
        "or sr.Budget(evaluations=500, seconds=20)."
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
