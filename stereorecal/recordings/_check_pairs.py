"""Checks of pairs before they are scored under a calibration."""

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import UPRIGHT, StereoRig, checked_rig, described_turns, fitted_to
from stereorecal.recordings._as_pairs import Pairs, as_pairs
from stereorecal.recordings._pair import Pair


def check_pairs(rig: StereoRig, pairs: Pairs) -> tuple[Pair, ...]:
    """The pairs as a tuple, turned as the rig says.

    Raises:
        InputError: if there are none, if one has another size than the calibration, or is the same image twice.
    """
    if checked_rig(rig) is not rig:
        raise InputError(f"{described_turns(rig.turns_wanted)}; give rig.side_by_side(), which turns pairs, too.")
    pairs = as_pairs(pairs)
    if not pairs:
        raise InputError("no image pair was given; give at least one.")
    return tuple(_fitting(rig, pair) for pair in pairs)


def _fitting(rig: StereoRig, pair: Pair) -> Pair:
    if pair.turns not in (UPRIGHT, rig.turns):
        raise InputError(
            f"{pair.name}: the images are turned for a rig that stands otherwise; give them as they were taken, "
            "pair.as_taken()."
        )
    pair = pair.turned(rig.turns) if pair.turns == UPRIGHT else pair
    if not rig.left.size == rig.right.size == pair.size:
        one = f", or {fitted_to(rig.left.size, pair.size)}" if rig.left.size == rig.right.size else ""
        raise InputError(
            f"{pair.name}: the images are {pair.size[0]}x{pair.size[1]}{' once turned' if any(pair.turns) else ''}, "
            f"but the calibration is for {rig.left.size[0]}x{rig.left.size[1]} (left) and "
            f"{rig.right.size[0]}x{rig.right.size[1]} (right); use images and calibration of the same size{one}."
        )
    check_two_images(pair)
    return pair


def check_two_images(pair: Pair) -> None:
    """Refuse a pair that is the same image twice.

    Raises:
        InputError: if it is.
    """
    if np.array_equal(pair.left, pair.right) and np.ptp(pair.left) > 0:
        raise InputError(f"{pair.name}: left and right are the same image; give one from each camera.")
