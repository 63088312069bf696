"""Numbers as people read them, in table cells and in text; a missing value (None) is a dash."""

import math
from collections.abc import Mapping


def number(value: float | None, digits: int) -> str:
    """The value with `digits` decimals."""
    return "-" if value is None else f"{value:.{digits}f}"


def count(value: float | None) -> str:
    """The value rounded to a whole number, its digits in groups of three."""
    return "-" if value is None else f"{value:,.0f}".replace(",", " ")


def percent(share: float | None) -> str:
    """A fraction as a whole number of percent."""
    return "-" if share is None else f"{100 * share:.0f} %"


def change(percent: float, word: str) -> str:
    """A relative change in percent, with its sign; above 100 % as a factor, such as "3.4 times as far" for `word`
    "far"; "beyond infinity" if it is infinite, as a depth is whose rays diverge."""
    if math.isnan(percent):
        return "unknown"
    if math.isinf(percent):
        return "beyond infinity"
    if percent <= 100.0:
        return f"{percent:+z.1f} %"
    factor = 1.0 + percent / 100.0
    return f"{number(factor, 1) if factor < 9.95 else count(factor)} times as {word}"


def depths(errors: Mapping[int, float]) -> str:
    """Errors of depth in percent, by distance in baselines, on one line."""
    return ", ".join(f"{change(percent, 'far')} at {distance} B" for distance, percent in errors.items())
