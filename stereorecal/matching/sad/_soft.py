"""The differentiable twin of the SAD search: the same windows and winners, with margins where the search has checks.

Which candidate wins is piecewise constant; by how much it wins is not. Each margin is continuous where a far rival
becomes the winner, and near the change from one disparity to the next the two share the pixel; so smooth gates make
the number of valid pixels smooth.
"""

import functools
import operator
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int

from stereorecal.matching._matcher import AbstractMatcher, SoftDisparity
from stereorecal.matching._texture import texture_response, x_sobel
from stereorecal.matching.sad._stream import (
    NEVER,
    index_bits,
    inside_right,
    minimum,
    offsets,
    seen_from_right,
    stream_costs,
)

_NOISE = 1.0  # grey levels per pixel of the window: keeps the margin of a perfect match finite


class _Candidate(NamedTuple):
    """A disparity of each pixel, what it costs, and the least cost of those farther than `near` from it."""

    offset: Int[jax.Array, "h w"]  # from 0 at min_disparity
    cost: Float[jax.Array, "h w"]
    rival: Float[jax.Array, "h w"]
    rivalled: Bool[jax.Array, "h w"]  # False: there is no rival


class _Found(NamedTuple):
    winner: _Candidate
    second: _Candidate  # the neighbour on the side of the sub-pixel part
    share: Float[jax.Array, "h w"]  # of the second, 0 to 1/2 where the two change places
    exists: Bool[jax.Array, "h w"]


@partial(jax.jit, static_argnames="options")
def soft_search(
    left: Float[jax.Array, "h w"],
    right: Float[jax.Array, "h w"],
    options: AbstractMatcher,
    temperature: Float[jax.Array, ""] | float,
) -> SoftDisparity:
    """Winners of the SAD search on images that are not rounded, and a smooth confidence in place of validity.

    Gates are sigmoids of margin / temperature. The margins of uniqueness and left-right check are in units of the
    winner's cost, that of texture in units of the threshold. As the temperature goes to 0, the confidence becomes
    the validity of `SAD` on the same images.
    """
    images = (left, right)
    if options.pre_filter_cap:
        images = tuple(x_sobel(image, options.pre_filter_cap) for image in images)
    found, from_right = _find(images[0], images[1], options, temperature)
    noise = _NOISE * options.block_size**2

    def gate(margin: jax.Array) -> jax.Array:
        return jax.nn.sigmoid(margin / temperature)

    def unique(candidate: _Candidate) -> jax.Array:
        excess = candidate.rival - (1.0 + options.uniqueness_ratio / 100.0) * candidate.cost
        return jnp.where(candidate.rivalled, gate(excess / (candidate.cost + noise)), 1.0)

    gates = []
    if options.uniqueness_ratio:
        gates.append(unique)
    if options.disp12_max_diff >= 0:
        gates.append(lambda candidate: _consistent(candidate, from_right, options, noise, gate))

    texture = jnp.ones_like(left)
    if options.texture_threshold:
        response = texture_response(left, options.block_size, options.pre_filter_cap)
        texture = gate(response / options.texture_threshold - 1.0)

    def confidence(candidate: _Candidate, share: jax.Array) -> jax.Array:
        return functools.reduce(operator.mul, (passes(candidate) for passes in gates), share * texture * found.exists)

    return SoftDisparity(
        options.min_disparity + jnp.stack([found.winner.offset, found.second.offset]),
        jnp.stack([confidence(found.winner, 1.0 - found.share), confidence(found.second, found.share)]),
    )


def _consistent(candidate: _Candidate, from_right: _Found, options: AbstractMatcher, noise: float, gate) -> jax.Array:
    """The left-right check as a margin: by how much the partner prefers this pixel, or another.

    If the partner's winner agrees, the margin is its rival's cost less its own; if not, its winner's cost less this
    pixel's. Both are 0 where its winner changes.
    """
    width = candidate.offset.shape[1]
    partner = jnp.clip(jnp.arange(width, dtype=jnp.int32) - (options.min_disparity + candidate.offset), 0, width - 1)

    def theirs(field: jax.Array) -> jax.Array:
        return jnp.take_along_axis(field, partner, axis=1)

    first, second = from_right.winner, from_right.second
    lead = first.rival - first.cost + from_right.share * (second.rival - first.rival)
    agrees = jnp.abs(theirs(first.offset) - candidate.offset) <= options.disp12_max_diff
    margin = jnp.where(agrees, theirs(lead), theirs(first.cost) - candidate.cost)
    alone = agrees & ~theirs(first.rivalled)
    return jnp.where(alone, 1.0, gate(margin / (candidate.cost + noise)))


def _find(
    left: Float[jax.Array, "h w"], right: Float[jax.Array, "h w"], options: AbstractMatcher, temperature
) -> tuple[_Found, _Found]:
    """Best candidates of every pixel of `left`, and of `right`, in float32; all costs carry their derivatives."""
    width = left.shape[1]
    lowest, count = options.disparity_range(width)
    column = jnp.arange(width, dtype=jnp.int32)
    inside = inside_right(options, width)
    low_bits = (1 << index_bits(count)) - 1

    def best_of_row(cost):
        # Floats that are not negative sort as their bits do; the lowest bits give way to the index.
        bits = jax.lax.bitcast_convert_type(jnp.maximum(jax.lax.stop_gradient(cost), 0.0), jnp.int32)
        packed = jnp.where(inside, (bits & ~low_bits) | offsets(count), NEVER)

        def from_left(i):
            return cost[count - 1 - i, column]

        def from_right(i):
            return cost[count - 1 - i, jnp.clip(column + lowest + i, 0, width - 1)]

        found = _best(from_left, packed, low_bits, 1, temperature)
        if options.disp12_max_diff < 0:
            return found, found
        packed = seen_from_right(packed, lowest)
        return found, _best(from_right, packed, low_bits, options.disp12_max_diff, temperature)

    return stream_costs(left, right, options, jnp.float32, best_of_row)


def _best(
    at: Callable[[jax.Array], jax.Array], packed: Int[jax.Array, "d w"], low_bits: int, near: int, temperature
) -> _Found:
    """Best candidates of a row.

    Args:
        at: offsets (w,) -> their costs.
        packed: the costs as whole numbers that sort alike, with the offset in their `low_bits`.
        near: a rival is farther than this from a candidate.
    """
    count = packed.shape[0]
    best = minimum(packed)
    exists = best < NEVER
    winner = jnp.where(exists, best & low_bits, 0)

    def candidate(i):
        rivals = minimum(jnp.where(jnp.abs(offsets(count) - i) <= near, NEVER, packed))
        rivalled = rivals < NEVER
        return _Candidate(i, at(i), at(jnp.where(rivalled, rivals & low_bits, 0)), rivalled)

    below, above = at(jnp.maximum(winner - 1, 0)), at(jnp.minimum(winner + 1, count - 1))
    first = candidate(winner)
    second = candidate(jnp.clip(jnp.where(above < below, winner + 1, winner - 1), 0, count - 1))
    # The parabola's vertex lies half a pixel from the winner where its neighbour costs the same.
    curvature = below + above - 2.0 * first.cost
    offset = 0.5 * jnp.abs(below - above) / jnp.maximum(curvature, 1e-3)
    width_of_change = jnp.minimum(temperature, 0.5)
    share = 0.5 * jnp.clip((offset - 0.5) / width_of_change + 1.0, 0.0, 1.0)
    return _Found(first, second, share, exists)
