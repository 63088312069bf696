"""Numbers and lists as people read them, in table cells and in text; a missing value (None) is a dash."""

import math
from collections.abc import Sequence

METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0}

MOST = 6


def number(value: float | None, digits: int) -> str:
    """The value with `digits` decimals."""
    return "-" if value is None else f"{value:z.{digits}f}"


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


def distance(metres: float) -> str:
    """A distance to two digits, in the unit that fits: "85 mm", "40 cm", "2.5 m"."""
    unit = _unit(metres)
    return f"{float(f'{metres / METRES[unit]:.2g}'):g} {unit}"


def between(low: float, high: float) -> str:
    """How much a depth is wrong, of an interval: "12 to 64 mm too far", "-12 to +64 mm" where it holds 0; "14 cm too
    near" where both ends are alike."""
    if math.isnan(low) or math.isnan(high):
        return "unknown"
    if math.isinf(low):
        return "beyond infinity"
    ends = (low, high) if math.isfinite(high) else (low,)
    largest = max(map(abs, ends))
    if largest < 5e-5 and math.isfinite(high):
        return "0 mm"
    unit = _unit(largest)
    digits = 1 if largest / METRES[unit] < 9.95 else 0
    sign, side = ("+", "") if low <= 0.0 <= high else ("", " too near" if high < 0.0 else " too far")
    shown = (f"{end / METRES[unit]:{sign}z,.{digits}f}" for end in (sorted(map(abs, ends)) if side else ends))
    text = f"{' to '.join(dict.fromkeys(shown)).replace(',', ' ')} {unit}{side}"
    return text if math.isfinite(high) else f"{text} to beyond infinity"


def _unit(metres: float) -> str:
    size = abs(metres)
    return "mm" if size < 0.0995 else "cm" if size < 0.995 else "m"


def short_list(names: Sequence[str], separator: str = ", ") -> str:
    """All of them, or, of more than `MOST`, the first and how many more there are."""
    if len(names) <= MOST:
        return separator.join(names)
    return separator.join([*names[: MOST - 1], f"{len(names) - MOST + 1} more"])
