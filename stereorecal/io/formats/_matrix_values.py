"""Matrices, in the shape in which a file has them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal.io.formats.text._keys import Keys, at

Array = Float[np.ndarray, "..."]


def matrix_values(content: Mapping[str, Any], keys: Keys, array: Array) -> dict[Keys, Any]:
    """What to write for an array where the file has a map of rows (or sizes), cols and data, or lists of any shape.

    A vector may be longer than the one in the file.
    """
    stated, flat = at(content, keys), np.asarray(array, float).ravel().tolist()
    if not isinstance(stated, Mapping):
        shape = np.shape(stated)
        return {keys: np.reshape(flat, shape).tolist() if np.prod(shape) == len(flat) else flat}
    values: dict[Keys, Any] = {(*keys, "data"): flat}
    if "dt" in stated and stated["dt"] != "d":  # single precision would lose digits
        values[(*keys, "dt")] = "d"
    if len(flat) > len(stated["data"]) and "sizes" in stated:
        sizes = stated["sizes"]
        longest = max(sizes) if isinstance(sizes, list) else sizes
        grown = [len(flat) if size == longest else size for size in sizes] if isinstance(sizes, list) else len(flat)
        values[(*keys, "sizes")] = grown
    elif len(flat) > len(stated["data"]):
        if not stated["data"]:
            values |= {(*keys, "rows"): 1, (*keys, "cols"): len(flat)}
        else:
            values[(*keys, "cols" if stated["rows"] == 1 else "rows")] = len(flat)
    return values


def derived_values(content: Mapping[str, Any], arrays: Mapping[str, Array]) -> dict[Keys, Any]:
    """What to write for those arrays that the file has."""
    values: dict[Keys, Any] = {}
    for key, array in arrays.items():
        if key in content:
            values.update(matrix_values(content, (key,), array))
    return values


def size_of(content: Mapping[str, Any], keys: Keys) -> int:
    """How many numbers stand under a key; 0 if there is none."""
    stated = at(content, keys)
    return int(np.size(stated["data"] if isinstance(stated, Mapping) else stated)) if stated is not None else 0
