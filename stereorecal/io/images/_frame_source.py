"""The frames of one camera (files, a video, a topic of a bag), read one by one; those of two cameras, matched by their
times; and times that are the names of images."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError

Image = Any  # an array as OpenCV has it: (h, w), or (h, w, 3 or 4) in BGR order


@dataclass(frozen=True, eq=False)
class FrameSource:
    """Frames by number."""

    where: str  # what error messages are about
    names: tuple[str, ...]  # of the frames
    times: Float[np.ndarray, "n"] | None  # (n,) seconds, ascending; None if they are not known
    read: Callable[[int], Image]  # makes the image of a number; raises InputError if it is damaged


def halves(source: FrameSource) -> tuple[FrameSource, FrameSource]:
    """The left and the right half of frames that show both images side by side. A frame is read once for both: to read
    one again, a video would be searched from its beginning."""
    cached = lru_cache(maxsize=1)(source.read)

    def half(index: int, side: int) -> Image:
        return halved(cached(index), source.names[index])[side]

    return replace(source, read=partial(half, side=0)), replace(source, read=partial(half, side=1))


def halved(image: Image, where: str) -> tuple[Image, Image]:
    """The left and the right half of an image."""
    width = image.shape[1]
    if width % 2:
        raise InputError(
            f"{where}: the image is {width} pixels wide, which cannot be halved; left and right image must have the "
            "same size."
        )
    return image[:, : width // 2], image[:, width // 2 :]


_OF_INTERVAL = 0.25  # of the time from one left frame to the next: the largest difference within a pair

_EXACT = 1e-6  # seconds: the resolution of float64 for nanoseconds since 1970


def pairs_by_time(
    first: Float[np.ndarray, "n"], second: Float[np.ndarray, "m"], tolerance: float | None
) -> list[tuple[int, int]]:
    """Numbers of left and right frames that belong together, of their ascending times: each the other's nearest, and
    near enough, in seconds; by default within a quarter of the usual interval between left frames."""
    if tolerance is None:
        tolerance = _OF_INTERVAL * float(np.median(np.diff(first))) if len(first) > 1 else float("inf")
    if not tolerance >= 0.0:
        raise InputError(f"a tolerance of {tolerance} s makes no sense; give seconds, such as 0.005.")
    # The nearest of the other side changes half-way between two; of two as near it is the earlier one.
    partners, back = (
        np.searchsorted((others[1:] + others[:-1]) / 2.0, times) for times, others in ((first, second), (second, first))
    )
    found = [
        (index, int(partner))
        for index, partner in enumerate(partners)
        if back[partner] == index and abs(first[index] - second[partner]) <= tolerance + _EXACT
    ]
    if not found:
        gap = float(np.min(np.abs(first - second[partners])))
        raise InputError(
            f"no two frames lie within {tolerance:.4g} s of each other, the nearest {gap:.4g} s apart; check the "
            "clocks, or the tolerance."
        )
    return found


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
    """Counts per second of numbers of 16 digits or more; None if frames would lie closer than a millisecond."""
    counts = sorted(int(stem) for stem in stems if stem.isdecimal())
    gap = float(np.median(np.diff(counts))) if len(counts) > 1 else float("inf")
    choices = (1e9, 1e6) if all(len(stem) == _COUNT for stem in stems) else (1e9,)
    return next((per_second for per_second in choices if gap / per_second >= _FASTEST), None)


def time_of(stem: str, per_second: float) -> float:
    """Seconds, of a name such as 12.345 or left_1403715273262142976: the number that it is (one of 16 digits or more
    counts `per_second`), or the one time in it."""
    try:
        text, value = stem, float(stem)
    except ValueError:
        if not has_time(stem):
            raise InputError(f"{stem}: the name is not a time; leave out the tolerance to pair by names.") from None
        text = _UNMISTAKABLE.findall(stem)[0]
        value, per_second = float(text), 1e9
    return value / per_second if len(text.partition(".")[0]) >= _COUNT else value
