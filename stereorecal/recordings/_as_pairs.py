"""Image pairs in the forms that users give, as a tuple of pairs; and their checks before they are scored."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import UPRIGHT, StereoRig, checked_rig, described_turns, fitted_to
from stereorecal.recordings._pair import Pair, make_pair

Images = tuple[np.ndarray, np.ndarray]  # left and right
Pairs = Pair | Images | Sequence[Pair | Images]
"""One pair or several; a pair may be a tuple of two arrays, (left, right): grey levels up to 255 (uint8 or float) stay
as they are, anything else, RGB among it, is converted by `make_pair`."""

_CALL = "give pairs such as sr.io.load_pairs('left/*.png', 'right/*.png'), or tuples (left, right) of arrays"


def as_pairs(pairs: Any) -> tuple[Pair, ...]:
    """The pairs of a single `Pair`, a tuple (left, right) of arrays, or a sequence of such.

    Raises:
        InputError: if it is something else, or an array cannot be an image (see `make_pair`).
    """
    if isinstance(pairs, Pair) or _is_images(pairs):
        return (_as_pair(pairs, 0),)
    if isinstance(pairs, str | bytes | np.ndarray) or not isinstance(pairs, Sequence):
        raise InputError(f"pairs is {_described(pairs)}; {_CALL}.")
    return tuple(_as_pair(pair, index) for index, pair in enumerate(pairs))


def _as_pair(pair: Any, index: int) -> Pair:
    if isinstance(pair, Pair):
        return pair
    if not _is_images(pair):
        raise InputError(f"pair {index} is {_described(pair)}; {_CALL}.")
    if all(_grey_levels(image) for image in pair):
        return Pair(pair[0], pair[1], f"pair {index}")
    return make_pair(*pair, name=f"pair {index}")


def _grey_levels(image: Any) -> bool:
    """Whether these are grey levels already: floats up to 255, and not just up to 1; never with NaN among them."""
    if not isinstance(image, np.ndarray) or isinstance(image, np.ma.MaskedArray):
        return False
    if image.ndim != 2 or image.dtype.kind != "f":
        return False
    return bool(image.min(initial=0.0) >= 0.0 and 1.0 < image.max(initial=0.0) <= 255.0)


def _is_images(value: Any) -> bool:
    return isinstance(value, tuple | list) and len(value) == 2 and all(hasattr(i, "__array__") for i in value)


def _described(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, tuple | list) and 0 < len(value) <= 2:
        return f"a {type(value).__name__} of {' and '.join(type(one).__name__ for one in value)}"
    return f"a {type(value).__name__}"


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
    if np.array_equal(pair.left, pair.right):
        raise InputError(f"{pair.name}: left and right are the same image; give one from each camera.")
