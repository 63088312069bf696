"""Frames of two cameras matched by their times."""

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.io.images._frame_source import FrameSource

_OF_INTERVAL = 0.25  # of the time from one left frame to the next: the largest difference within a pair

_EXACT = 1e-6  # seconds: the resolution of float64 for nanoseconds since 1970


def pairs_by_time(left: FrameSource, right: FrameSource, tolerance: float | None) -> list[tuple[int, int]]:
    """Numbers of left and right frames that belong together: each the other's nearest, and near enough.

    Args:
        tolerance: seconds; default a quarter of the usual interval between left frames.

    Raises:
        InputError: if times are not known, the tolerance makes no sense, or no frame has a partner.
    """
    first, second = (_required_times(source) for source in (left, right))
    if tolerance is None:
        tolerance = _OF_INTERVAL * float(np.median(np.diff(first))) if len(first) > 1 else float("inf")
    if not tolerance >= 0.0:
        raise InputError(f"a tolerance of {tolerance} s makes no sense; give seconds, such as 0.005.")
    partners, back = _nearest(first, second), _nearest(second, first)
    found = [
        (index, int(partner))
        for index, partner in enumerate(partners)
        if back[partner] == index and abs(first[index] - second[partner]) <= tolerance + _EXACT
    ]
    if not found:
        gap = float(np.min(np.abs(first - second[partners])))
        raise InputError(
            f"{left.where} and {right.where}: no two frames lie within {tolerance:.4g} s of each other, the nearest "
            f"{gap:.4g} s apart; check the clocks, or give a larger tolerance."
        )
    return found


def _required_times(source: FrameSource) -> Float[np.ndarray, "n"]:
    if source.times is None:
        raise InputError(f"{source.where}: these frames have no times; give the tolerance for frames that have.")
    return source.times


def _nearest(times: Float[np.ndarray, "n"], others: Float[np.ndarray, "m"]) -> np.ndarray:
    """The number of the nearest of `others`, which ascend."""
    after = np.clip(np.searchsorted(others, times), 1, max(len(others) - 1, 1))
    if len(others) == 1:
        return np.zeros(len(times), int)
    before = after - 1
    return np.where(np.abs(times - others[before]) <= np.abs(others[after] - times), before, after)
