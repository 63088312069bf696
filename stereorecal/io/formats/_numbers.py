"""The one reader of numbers: what a calibration file says under a key, as a finite float64 array or in one sentence."""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError

# A matrix nests two levels; some programs write a row or column around it. NumPy itself stops at 64.
_DEEPEST = 4
# The largest width and height of an image that OpenCV reads by default (its CV_IO_MAX_IMAGE_WIDTH).
_WIDEST = 1 << 20


def numbers(content: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Float[np.ndarray, "..."]:
    """The finite float64 array under a key, which holds a number, nested lists of numbers, or `rows cols data`.

    Axes of length one are dropped, so that rows and columns are vectors: (1, 5) and (5, 1) become (5,).

    Args:
        shape: what the array must have; (-1,) is a vector of any length.

    Raises:
        InputError: naming the key, if it is missing or holds anything else, such as text, true or false, null, NaN, a
            number too large for a float64, or rows of different lengths.
    """
    array = _array(unpacked(value(content, key)), key).squeeze()
    if len(shape) == 1:
        array = np.atleast_1d(array)
    if shape not in (array.shape, (-1,) * array.ndim):
        expected = (
            "one number" if shape == () else "a list of numbers" if -1 in shape else f"{_shape_text(shape)} numbers"
        )
        raise InputError(
            f"{key} must hold {expected}, not {_shape_text(array.shape) or 'one'}; correct it, or copy the file again."
        )
    return array


def scalars(content: Mapping[str, Any], keys: Sequence[str]) -> Float[np.ndarray, "n"]:
    """The numbers under these keys, one under each."""
    return np.array([float(numbers(content, key, ())) for key in keys])


def array_or_none(stated: Any) -> Float[np.ndarray, "..."] | None:
    """What is stated as a finite float64 array, as `numbers` reads it, of any shape; None if it is none."""
    try:
        array = _array(unpacked(stated), "")
    except InputError:
        return None
    return np.atleast_1d(array.squeeze()) if array.ndim else array


def value(content: Mapping[str, Any], key: str) -> Any:
    """The value under a key."""
    if key not in content:
        close = _misspelt(key, content)
        hint = f"rename {close!r} if that is meant" if close else "add it"
        raise InputError(f"the key {key!r} is missing; {hint}, or copy the file again.")
    return content[key]


def optional(content: Mapping[str, Any], key: str) -> Any:
    """The value under a key; None if there is no such key."""
    misspelt = _misspelt(key, content)
    if key not in content and misspelt:
        raise InputError(f"the key {misspelt!r} is not known; rename it if {key!r} is meant, or remove it.")
    return content.get(key)


def _misspelt(key: str, content: Mapping[str, Any]) -> str | None:
    """A key that is written almost like another one; not one that differs by a number: that is the other camera's."""
    close = difflib.get_close_matches(key, map(str, content), 1, 0.9)
    return next((other for other in close if re.findall(r"\d", other) == re.findall(r"\d", key)), None)


def unpacked(stated: Any) -> Any:
    """A map of rows, cols and data (OpenCV, ROS), or of sizes and data (OpenCV 5), as a list or a list of rows; all
    else as it is."""
    match stated:
        case {"rows": _, "cols": _, "data": []}:
            return []
        case {"rows": int(rows), "cols": int(columns), "data": list(data)} if columns > 0:
            # If the numbers do not fill the matrix they stay a flat list, and the reader says what it expected.
            fits = rows * columns == len(data)
            return [data[start : start + columns] for start in range(0, len(data), columns)] if fits else data
        case {"sizes": [int(rows), int(columns)], "data": list(data)}:
            return unpacked({"rows": rows, "cols": columns, "data": data})
        case {"sizes": _, "data": list(data)}:
            return data
        case _:
            return stated


def image_size(content: Mapping[str, Any], key: str) -> tuple[int, int]:
    """The (width, height) in pixels under a key."""
    width, height = numbers(content, key, (2,))
    return _pixels(width, key), _pixels(height, key)


def pixels(content: Mapping[str, Any], key: str) -> int:
    """The width or height of an image under a key."""
    return _pixels(numbers(content, key, ()), key)


def number_or_word(word: str) -> float | str:
    """A word of a text file as a number if it is one, else as it is."""
    try:
        return float(word) if word.isascii() and "_" not in word else word  # float() would read "1_0" as 10
    except ValueError:
        return word


def _array(stated: Any, key: str) -> Float[np.ndarray, "..."]:
    leaves = list(_leaves(stated))
    if any(leaf is None for leaf in leaves):
        raise InputError(f"{key} contains null (no value); give numbers.")
    if not all(isinstance(leaf, int | float) and not isinstance(leaf, bool) for leaf in leaves):
        raise _no_array(key)
    try:
        array = np.array(stated, float)
    except ValueError:  # rows of different lengths
        raise _no_array(key) from None
    except OverflowError:  # an integer beyond float64
        array = np.array(np.inf)
    if not np.isfinite(array).all():
        raise InputError(f"{key} contains NaN or infinite numbers; correct it.")
    return array


def _leaves(stated: Any, depth: int = 0) -> Iterator[Any]:
    """What nested lists contain; a list that is nested too deeply is left as it is."""
    if isinstance(stated, list) and depth < _DEEPEST:
        for item in stated:
            yield from _leaves(item, depth + 1)
    else:
        yield stated


def _no_array(key: str) -> InputError:
    return InputError(f"{key} is not an array of numbers; correct it, or copy the file again.")


def _shape_text(shape: tuple[int, ...]) -> str:
    return "x".join(map(str, shape))


def _pixels(number: float | Float[np.ndarray, ""], key: str) -> int:
    if number != np.rint(number) or not 1 <= number <= _WIDEST:
        raise InputError(
            f"{key} is {number:g}, but an image size is a whole number of pixels from 1 to {_WIDEST}; correct it."
        )
    return int(number)
