"""Numbers out of what a text file said."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError


def numbers(content: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Float[np.ndarray, "..."]:
    """The finite float64 array under a key: nested lists of numbers, or of their text, as the file has them.

    Rows and columns of one are dropped: (1, 5) and (5, 1) are (5,).

    Args:
        shape: what it must have; (-1,) is a row of any length.

    Raises:
        InputError: naming the key, if it is missing or holds something else.
    """
    stated = value(content, key)
    try:
        array = np.array(stated, float).squeeze()
    except (TypeError, ValueError):
        raise InputError(f"{key} is not an array of numbers; correct it, or copy the file again.") from None
    if not np.isfinite(array).all():
        raise InputError(f"{key} contains NaN or infinite numbers, or no value; correct it.")
    if len(shape) == 1:
        array = np.atleast_1d(array)
    if shape not in (array.shape, (-1,) * array.ndim):
        expected = "one number" if shape == () else "a row of numbers" if -1 in shape else f"{_times(shape)} numbers"
        raise InputError(
            f"{key} must hold {expected}, not {_times(array.shape) or 'one'}; correct it, or copy the file again."
        )
    return array


def _times(shape: tuple[int, ...]) -> str:
    return "x".join(map(str, shape))


def value(content: Mapping[str, Any], key: str) -> Any:
    """What is under a key.

    Raises:
        InputError: if it is missing.
    """
    if key not in content:
        raise InputError(f"the key {key!r} is missing; add it, or copy the file again.")
    return content[key]


def image_size(content: Mapping[str, Any], key: str) -> tuple[int, int]:
    """The (width, height) in pixels under a key.

    Raises:
        InputError: if it is missing or not two whole numbers.
    """
    width, height = numbers(content, key, (2,))
    return whole(width, key), whole(height, key)


def whole(number: float | Float[np.ndarray, ""], key: str) -> int:
    """A number of pixels.

    Raises:
        InputError: naming the key, if it is not whole.
    """
    if number != np.rint(number):
        raise InputError(f"{key} is {number}, but pixels come in whole numbers; correct it.")
    return int(number)
