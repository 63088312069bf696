"""Window costs of a pair of images, row by row: the state is one column sum for each (disparity, column)."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Num

from stereorecal.matching._matcher import AbstractMatcher

NEVER = 2**31 - 1  # packed cost of a candidate outside the right image


def inside_right(options: AbstractMatcher, width: int) -> Bool[jax.Array, "d w"]:
    """Which candidates of a row lie inside the right image."""
    lowest, count = options.disparity_range(width)
    target = jnp.arange(width, dtype=jnp.int32) - (lowest + jnp.arange(count, dtype=jnp.int32))[:, None]
    return (target >= 0) & (target < width)


def stream_costs(
    left: Num[jax.Array, "h w"],
    right: Num[jax.Array, "h w"],
    options: AbstractMatcher,
    sum_type: Any,
    use: Callable[[Num[jax.Array, "d w"]], Any],
) -> Any:
    """`use(cost)` of each row, stacked; cost (d, w) are the sums of absolute differences over the windows.

    Outside the right image its border repeats; outside its rows both images are 0 and cost nothing.

    Args:
        sum_type: a dtype that holds the sum of a window.
    """
    height, width = left.shape
    lowest, count = options.disparity_range(width)
    radius = options.block_size // 2
    left_rows = jnp.pad(left, ((radius, radius), (0, 0)))
    before, after = max(lowest + count - 1, 0), max(-lowest, 0)
    right_rows = jnp.pad(jnp.pad(right, ((0, 0), (before, after)), mode="edge"), ((radius, radius), (0, 0)))
    index = jnp.arange(count, dtype=jnp.int32)

    def absolute_differences(left_row, right_row):
        shifted = jax.vmap(lambda i: jax.lax.dynamic_slice(right_row, (before - lowest - i,), (width,)))(index)
        return jnp.abs(left_row - shifted).astype(sum_type)

    def add_row(column_sums, rows):
        return column_sums + absolute_differences(*rows), None

    def step(column_sums, rows):
        entering, leaving = rows
        column_sums = column_sums + absolute_differences(*entering) - absolute_differences(*leaving)
        padded = jnp.pad(column_sums, ((0, 0), (radius, radius)))
        cost = padded[:, :width]
        for offset in range(1, options.block_size):
            cost = cost + padded[:, offset : offset + width]
        return column_sums, use(cost)

    def rows(start, stop):
        return left_rows[start:stop], right_rows[start:stop]

    start = jnp.zeros((count, width), sum_type)
    start, _ = jax.lax.scan(add_row, start, rows(0, 2 * radius))
    leaving = tuple(jnp.pad(r, ((1, 0), (0, 0)))[:height] for r in (left_rows, right_rows))
    _, found = jax.lax.scan(step, start, (rows(2 * radius, height + 2 * radius), leaving))
    return found
