"""Times that are the names of images."""

import re
from collections.abc import Sequence

import numpy as np

from stereorecal._errors import InputError

_COUNT = 16  # digits and more of a name that counts fractions of seconds
_FASTEST = 1e-3  # seconds from frame to frame: read in a wrong unit, they lie closer
# What is nothing but a time since 1970: seconds with a fraction, or nanoseconds.
_UNMISTAKABLE = re.compile(r"(?<![0-9.])(?:[0-9]{10}\.[0-9]+|[0-9]{19})(?![0-9.])")


def has_time(stem: str) -> bool:
    """Whether a name without suffix holds one time since 1970."""
    return len(_UNMISTAKABLE.findall(stem)) == 1


def counted_times(stems: Sequence[str]) -> list[float] | None:
    """Seconds, if all names are numbers of 16 digits or more that count nanoseconds (or microseconds, 16 digits) by
    their distances; else None: a date, such as 20240501123015123, counts nothing."""
    if not all(stem.isascii() and stem.isdigit() and len(stem) >= _COUNT for stem in stems):
        return None
    per_second = counts_per_second(stems)
    return None if per_second is None else [int(stem) / per_second for stem in stems]


def counts_per_second(stems: Sequence[str]) -> float | None:
    """Of numbers of 16 digits or more; None if frames would lie closer than a millisecond."""
    counts = sorted(int(stem) for stem in stems if stem.isdecimal())
    gap = float(np.median(np.diff(counts))) if len(counts) > 1 else float("inf")
    choices = (1e9, 1e6) if all(len(stem) == _COUNT for stem in stems) else (1e9,)
    return next((per_second for per_second in choices if gap / per_second >= _FASTEST), None)


def time_of(stem: str, per_second: float) -> float:
    """Seconds, of a name such as 12.345 or left_1403715273262142976: the number that it is, or the one time in it.

    Args:
        per_second: counts of a number of 16 digits or more.

    Raises:
        InputError: if it is no time.
    """
    try:
        text, value = stem, float(stem)
    except ValueError:
        if not has_time(stem):
            raise InputError(f"{stem}: the name is not a time; leave out the tolerance to pair by names.") from None
        text = _UNMISTAKABLE.findall(stem)[0]
        value, per_second = float(text), 1e9
    return value / per_second if len(text.partition(".")[0]) >= _COUNT else value
