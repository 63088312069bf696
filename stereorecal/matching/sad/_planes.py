"""Window costs of whole images, one disparity after another: the form that suits a GPU.

Where `_stream.py` keeps a row's costs in a core's cache, here each disparity is one pass over the image, as wide as the
machine, and nothing but the best so far is kept. The costs are computed twice: rivals and neighbours of
the best are known only once the best is.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Int, Num

from stereorecal.matching._matcher import AbstractMatcher
from stereorecal.matching._texture import box_sum
from stereorecal.matching.sad._stream import NEVER, with_borders
from stereorecal.matching.sad._winners import Winners, highest_rival_cost, index_bits, index_of


def winners(left: Num[jax.Array, "h w"], right: Num[jax.Array, "h w"], options: AbstractMatcher) -> Winners:
    """What `sad.py` finds by streaming, bit for bit."""
    (height, width), radius = left.shape, options.block_size // 2
    lowest, count = options.disparity_range(width)
    bits = index_bits(count)
    wide_left, wide_right, first = with_borders(left, right, options)
    column = jnp.arange(width, dtype=jnp.int32)

    def packed_at(index: Any) -> Int[jax.Array, "h w"]:
        shift = lowest + index
        moved = jax.lax.dynamic_slice_in_dim(wide_right, first - index, wide_left.shape[1], axis=1)
        cost = box_sum(jnp.abs(wide_left - moved), options.block_size)[radius:-radius, radius:-radius]
        inside = (column >= shift) & (column < width + shift)
        return jnp.where(inside, (cost << bits) | index, NEVER)

    def better(best, index):
        best_cost, from_right = best
        packed = packed_at(index)
        right_packed = jax.lax.dynamic_slice_in_dim(
            jnp.pad(packed, ((0, 0), (count + abs(lowest),) * 2), constant_values=NEVER),
            count + abs(lowest) + lowest + index,
            packed.shape[1],
            axis=1,
        )
        return (jnp.minimum(best_cost, packed), jnp.minimum(from_right, right_packed)), None

    nothing = jnp.full((height, width), NEVER, jnp.int32)
    indices = jnp.arange(count, dtype=jnp.int32)
    (best, from_right), _ = jax.lax.scan(better, (nothing, nothing), indices)

    winner, lowest_cost = index_of(best, bits), best >> bits
    limit = highest_rival_cost(lowest_cost, options.uniqueness_ratio)

    def compare(seen, index):
        rivals, below, above = seen
        packed = packed_at(index)
        cost = jnp.where(packed < NEVER, packed >> bits, NEVER)
        rivals = rivals + ((jnp.abs(index - winner) > 1) & (cost <= limit))
        below = jnp.where(index == winner - 1, cost, below)
        return (rivals, below, jnp.where(index == winner + 1, cost, above)), None

    start = (jnp.zeros((height, width), jnp.int32), nothing, nothing)
    (rivals, below, above), _ = jax.lax.scan(compare, start, indices)
    cost = jnp.where(best < NEVER, lowest_cost, NEVER)
    return Winners(winner, cost, rivals, below, above, index_of(from_right, bits))
