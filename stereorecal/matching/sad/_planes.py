"""Window costs of whole images, several disparities at a time: the form that suits a GPU.

Where `_stream.py` keeps a row's costs in a core's cache, here a group of disparities is one pass over the image, as
wide as the machine, and nothing but the best so far is kept. The costs are computed twice: rivals and neighbours of
the best are known only once the best is.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Int, Num

from stereorecal.matching._matcher import AbstractMatcher
from stereorecal.matching._texture import box_sum
from stereorecal.matching.sad._stream import (
    NEVER,
    Winners,
    highest_rival_cost,
    index_bits,
    index_of,
    with_borders,
)

_GROUP = 4


def winners(left: Num[jax.Array, "h w"], right: Num[jax.Array, "h w"], options: AbstractMatcher) -> Winners:
    """What `sad.py` finds by streaming, bit for bit."""
    (height, width), radius = left.shape, options.block_size // 2
    lowest, count = options.disparity_range(width)
    bits = index_bits(count)
    wide_left, wide_right, first = with_borders(left, right, options)
    column = jnp.arange(width, dtype=jnp.int32)
    border = count + abs(lowest)

    def packed_at(index: Any) -> Int[jax.Array, "h w"]:
        shift = lowest + index
        moved = jax.lax.dynamic_slice_in_dim(wide_right, first - index, wide_left.shape[1], axis=1)
        cost = box_sum(jnp.abs(wide_left - moved), options.block_size)[radius:-radius, radius:-radius]
        inside = (column >= shift) & (column < width + shift) & (index < count)
        return jnp.where(inside, (cost << bits) | index, NEVER)

    def from_the_right(packed: Int[jax.Array, "h w"], index: Any) -> Int[jax.Array, "h w"]:
        padded = jnp.pad(packed, ((0, 0), (border, border)), constant_values=NEVER)
        return jax.lax.dynamic_slice_in_dim(padded, border + lowest + index, width, axis=1)

    def better(best, group):
        best_cost, from_right = best
        packed = jax.vmap(packed_at)(group)
        right_packed = jax.vmap(from_the_right)(packed, group)
        return (jnp.minimum(best_cost, packed.min(axis=0)), jnp.minimum(from_right, right_packed.min(axis=0))), None

    nothing = jnp.full((height, width), NEVER, jnp.int32)
    groups = jnp.arange(-(-count // _GROUP) * _GROUP, dtype=jnp.int32).reshape(-1, _GROUP)
    (best, from_right), _ = jax.lax.scan(better, (nothing, nothing), groups)

    winner, lowest_cost = index_of(best, bits), best >> bits
    limit = highest_rival_cost(lowest_cost, options.uniqueness_ratio)

    def compare(seen, group):
        rivals, below, above = seen
        packed = jax.vmap(packed_at)(group)
        cost = jnp.where(packed < NEVER, packed >> bits, NEVER)
        away = group[:, None, None] - winner
        rivals = rivals + ((jnp.abs(away) > 1) & (cost <= limit)).sum(axis=0, dtype=jnp.int32)
        below = jnp.minimum(below, jnp.where(away == -1, cost, NEVER).min(axis=0))
        above = jnp.minimum(above, jnp.where(away == 1, cost, NEVER).min(axis=0))
        return (rivals, below, above), None

    start = (jnp.zeros((height, width), jnp.int32), nothing, nothing)
    (rivals, below, above), _ = jax.lax.scan(compare, start, groups)
    cost = jnp.where(best < NEVER, lowest_cost, NEVER)
    return Winners(winner, cost, rivals, below, above, index_of(from_right, bits))
