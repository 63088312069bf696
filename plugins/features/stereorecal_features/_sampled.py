"""Fields at places between their pixels, as torch's `grid_sample` has them (corners not aligned, zero outside)."""

import numpy as np
from jaxtyping import Float

_CUBIC = -0.75  # of the kernel, torch's choice


def bilinear(fields: Float[np.ndarray, "c h w"], places: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m c"]:
    """At places (column, row) in pixels of the fields."""
    return _sampled(fields, places, lambda t: np.stack([1.0 - t, t]), 0)


def bicubic(fields: Float[np.ndarray, "c h w"], places: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m c"]:
    """At places (column, row) in pixels of the fields."""
    return _sampled(fields, places, _cubic, 1)


def _cubic(t: Float[np.ndarray, "2 m"]) -> Float[np.ndarray, "4 2 m"]:
    """Weights of the four neighbours of a place that lies `t` behind the second (Keys 1981)."""
    near = [((_CUBIC + 2.0) * s - (_CUBIC + 3.0)) * s * s + 1.0 for s in (t, 1.0 - t)]
    far = [((_CUBIC * s - 5.0 * _CUBIC) * s + 8.0 * _CUBIC) * s - 4.0 * _CUBIC for s in (1.0 + t, 2.0 - t)]
    return np.stack([far[0], *near, far[1]])


def _sampled(fields, places, weights_of, before: int) -> Float[np.ndarray, "m c"]:
    _, height, width = fields.shape
    first = np.floor(places.T)
    weights = weights_of(places.T - first)
    found = np.zeros((len(places), len(fields)), fields.dtype)
    for i, of_columns in enumerate(weights[:, 0]):
        for j, of_rows in enumerate(weights[:, 1]):
            column, row = (first + np.array([[i - before], [j - before]])).astype(int)
            inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            values = fields[:, np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)].T
            found += (inside * of_columns * of_rows)[:, None] * values
    return found
