"""Matrices, in the shape in which a file has them: camera matrices of 3x4, rotation vectors, few coefficients."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.io.formats._numbers import numbers, unpacked
from stereorecal.io.formats.text._nodes import Keys, at

Array = Float[np.ndarray, "..."]


def camera_matrix(content: Mapping[str, Any], key: str) -> Mat3:
    """The camera matrix under a key: 3x3, or 3x4 with a fourth column of zeros."""
    if size_of(content, (key,)) != 12:
        return numbers(content, key, (3, 3))
    matrix = numbers(content, key, (3, 4))
    if np.any(matrix[:, 3]):
        raise InputError(
            f"{key} is the projection matrix of rectified images (its fourth column is not zero), no camera matrix; "
            "give the camera matrix, 3x3."
        )
    return matrix[:, :3]


def rotation_matrix(content: Mapping[str, Any], key: str) -> Mat3:
    """The rotation under a key: a matrix, or a rotation vector of `cv2.Rodrigues` [rad]."""
    if size_of(content, (key,)) != 3:
        return numbers(content, key, (3, 3))
    vector = numbers(content, key, (3,))
    if np.linalg.norm(vector) > np.pi:
        raise InputError(
            f"{key} has three numbers, but is no rotation vector in radians (its length is "
            f"{np.linalg.norm(vector):.3g}, more than pi); give the rotation matrix, such as cv2.Rodrigues(rvec)[0]."
        )
    return cv2.Rodrigues(vector)[0]


def lens_coefficients(content: Mapping[str, Any], key: str) -> Float[np.ndarray, "n"]:
    """The coefficients of a pinhole under a key; k1, or k1 k2, may stand alone."""
    found = numbers(content, key, (-1,))
    if found.size == 3:
        raise UnsupportedModelError(
            f"the distortion has 3 coefficients ({key}), which are k1 k2 k3 or k1 k2 p1; write them in OpenCV's order, "
            "k1 k2 0 0 k3 or k1 k2 p1 0."
        )
    return np.pad(found, (0, 4 - found.size)) if found.size in (1, 2) else found


def matrix_values(content: Mapping[str, Any], keys: Keys, array: Array) -> dict[Keys, Any]:
    """What to write for an array where the file has a map of rows (or sizes), cols and data, or lists of any shape.

    A vector may be longer than the one in the file; a camera matrix stays one of 3x4, and a rotation a vector.
    """
    stated, array = at(content, keys), np.asarray(array, float)
    if array.shape == (3, 3) and size_of(content, keys) in (3, 12):
        array = np.pad(array, ((0, 0), (0, 1))) if size_of(content, keys) == 12 else cv2.Rodrigues(array)[0]
    flat = array.ravel().tolist()
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


def size_of(content: Mapping[str, Any], keys: Keys) -> int:
    """How many numbers stand under a key; 0 if there is none, or they are no array."""
    stated = unpacked(at(content, keys))
    try:
        return int(np.size(stated)) if stated is not None else 0
    except ValueError:  # rows of different lengths, which the reader of numbers names
        return 0
