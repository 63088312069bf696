"""What a search over the costs leaves of them: for each pixel the best candidate, and what came near it."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Int

from stereorecal.matching.sad._stream import NEVER


class Winners(NamedTuple):
    """Indices count from 0 at `min_disparity`; a cost is NEVER where there is no candidate.

    Attributes:
        winner: index of the best candidate.
        cost: its cost.
        rivals: how many others, neighbours apart, come as near as `uniqueness_ratio` forbids.
        below, above: costs at winner - 1 and winner + 1.
        from_right: the winner of each pixel of the right image; meaningless where the left-right check is off.
    """

    winner: Int[jax.Array, "h w"]
    cost: Int[jax.Array, "h w"]
    rivals: Int[jax.Array, "h w"]
    below: Int[jax.Array, "h w"]
    above: Int[jax.Array, "h w"]
    from_right: Int[jax.Array, "h w"]


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
