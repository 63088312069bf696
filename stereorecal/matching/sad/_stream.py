"""Window costs of a pair of images, row by row: the state is one column sum for each (disparity, column); what a search
over the costs leaves of them; and reductions by halving.
"""

import functools
import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Int, Num

from stereorecal.matching._matcher import AbstractMatcher

NEVER = 2**31 - 1  # more than any cost, packed or not: of what is not there


def offsets(count: int) -> Int[jax.Array, "d 1"]:
    """Disparities above min_disparity in the order of the cost rows: from the largest to the smallest, so that
    `seen_from_right` reads forwards."""
    return jnp.arange(count - 1, -1, -1, dtype=jnp.int32)[:, None]


def inside_right(options: AbstractMatcher, width: int) -> Bool[jax.Array, "d w"]:
    """Which candidates of a row lie inside the right image."""
    lowest, count = options.disparity_range(width)
    target = jnp.arange(width, dtype=jnp.int32) - (lowest + offsets(count))
    return (target >= 0) & (target < width)


def seen_from_right(costs: Int[jax.Array, "d w"], lowest: int, outside: int = NEVER) -> Int[jax.Array, "d w"]:
    """The same candidates, sorted by the pixel of the right image that they meet; `outside` where there is none.

    Pixel x of the left image meets x - disparity: a shear, whose rows are slices of the flat array.
    """
    count, width = costs.shape
    before, after = max(1 - count - lowest, 0), max(lowest, 0)  # so that all slices lie inside the array
    flat = jnp.pad(costs.reshape(-1), (before, after))
    first = jnp.arange(count, dtype=jnp.int32) * (width - 1) + count - 1 + lowest + before
    sheared = jax.vmap(lambda k: jax.lax.dynamic_slice(flat, (k,), (width,)))(first)
    column = jnp.arange(width, dtype=jnp.int32) + lowest + offsets(count)
    return jnp.where((column >= 0) & (column < width), sheared, jnp.asarray(outside, costs.dtype))


def stream_costs(
    left: Num[jax.Array, "h w"],
    right: Num[jax.Array, "h w"],
    options: AbstractMatcher,
    sum_type: Any,
    use: Callable[[Num[jax.Array, "d w"]], Any],
) -> Any:
    """`use(cost)` of each row, stacked; cost (d, w) are the sums of absolute differences over the windows, in the
    order of `offsets`.

    Args:
        sum_type: a dtype that holds the sum of a window.
    """
    height, width = left.shape
    _, count = options.disparity_range(width)
    radius = options.block_size // 2
    left_rows, right_rows, first = with_borders(left, right, options)
    # The column sums reach as far as the windows do: padding them in the loop would cost more than the sums.
    wide = width + 2 * radius
    first_column = first - offsets(count)[:, 0]

    def absolute_differences(left_row, right_row):
        shifted = jax.vmap(lambda first: jax.lax.dynamic_slice(right_row, (first,), (wide,)))(first_column)
        return jnp.abs(left_row - shifted).astype(sum_type)

    def add_row(column_sums, rows):
        return column_sums + absolute_differences(*rows), None

    def step(column_sums, rows):
        entering, leaving = rows
        column_sums = column_sums + absolute_differences(*entering) - absolute_differences(*leaving)
        return column_sums, use(_windows(column_sums, width))

    def rows(start, stop):
        return left_rows[start:stop], right_rows[start:stop]

    start = jnp.zeros((count, wide), sum_type)
    start, _ = jax.lax.scan(add_row, start, rows(0, 2 * radius))
    leaving = tuple(jnp.pad(r, ((1, 0), (0, 0)))[:height] for r in (left_rows, right_rows))
    _, found = jax.lax.scan(step, start, (rows(2 * radius, height + 2 * radius), leaving))
    return found


def with_borders(
    left: Num[jax.Array, "h w"], right: Num[jax.Array, "h w"], options: AbstractMatcher
) -> tuple[Num[jax.Array, "hh ww"], Num[jax.Array, "hh wr"], int]:
    """Both images as far as windows reach, and the column of the right one that the first of the left one meets at
    min_disparity.

    Beyond their columns both images repeat their border, so that a cost is the same from either image; beyond their
    rows both are 0 and cost nothing.
    """
    radius = options.block_size // 2
    lowest, count = options.disparity_range(left.shape[1])
    before, after = max(radius + lowest + count - 1, 0), max(radius - lowest, 0)
    wide = _with_border(left, radius, (radius, radius)), _with_border(right, radius, (before, after))
    return *wide, before - radius - lowest


def _with_border(image: Num[jax.Array, "h w"], rows: int, columns: tuple[int, int]) -> Num[jax.Array, "hh ww"]:
    return jnp.pad(jnp.pad(image, ((0, 0), columns), mode="edge"), ((rows, rows), (0, 0)))


def _windows(column_sums: Num[jax.Array, "d ww"], width: int) -> Num[jax.Array, "d w"]:
    """Sums of as many neighbours as leave `width` of them."""
    neighbours = range(column_sums.shape[1] - width + 1)
    return functools.reduce(operator.add, (column_sums[:, i : i + width] for i in neighbours))


class Winners(NamedTuple):
    """Indices count from 0 at `min_disparity`; a cost is NEVER where there is no candidate."""

    winner: Int[jax.Array, "h w"]  # index of the best candidate
    cost: Int[jax.Array, "h w"]  # its cost
    rivals: Int[jax.Array, "h w"]  # how many others, neighbours apart, come as near as `uniqueness_ratio` forbids
    below: Int[jax.Array, "h w"]  # cost at winner - 1
    above: Int[jax.Array, "h w"]  # cost at winner + 1
    from_right: Int[jax.Array, "h w"]  # winner of each pixel of the right image, where the left-right check is on


def index_bits(count: int) -> int:
    """How many bits an index needs; cost and index share one int32, so that a single minimum finds both, and ties go to
    the smaller index."""
    return max(1, (count - 1).bit_length())


def index_of(packed: Int[jax.Array, "*shape"], bits: int) -> Int[jax.Array, "*shape"]:
    """The index in cost and index together; 0 where there is no candidate."""
    return jnp.where(packed < NEVER, packed & ((1 << bits) - 1), 0)


def highest_rival_cost(cost: Int[jax.Array, "*shape"], uniqueness_ratio: int) -> Int[jax.Array, "*shape"]:
    """cost + cost * uniqueness_ratio // 100: what costs no more than that comes too near to the winner. Without the
    product, which int32 does not always hold."""
    return cost + cost // 100 * uniqueness_ratio + cost % 100 * uniqueness_ratio // 100


def minimum(rows: Int[jax.Array, "d w"]) -> Int[jax.Array, "w"]:
    """Minimum over the rows, by halving, which XLA's CPU compiler vectorises, unlike its own reductions over a first
    axis (half the time of the whole search, measured).

    The last two rows are left to XLA's own reduction, which it never fuses into what reads it. Otherwise XLA would
    recompute the minimum in every step that uses it (a third of the time of the whole search).
    """
    while (n := rows.shape[0]) > 2:
        half = (n + 1) // 2
        rows = jnp.minimum(rows[:half], rows[n - half :])
    return jnp.min(rows, axis=0)


def total(rows: Int[jax.Array, "d w"]) -> Int[jax.Array, "w"]:
    """Sum over the rows, by halving, too."""
    while (n := rows.shape[0]) > 1:
        half = n // 2
        pairs = rows[:half] + rows[half : 2 * half]
        rows = jnp.concatenate([pairs, rows[2 * half :]]) if n % 2 else pairs
    return rows[0]
