"""Block matching by sums of absolute differences, in JAX.

On a CPU the image is streamed row by row: the state is one column sum for each (disparity, column), so memory is
O(width x disparities) and a row's costs stay in cache; in compiled code where it is installed, `_kernel.py`. Elsewhere
it is searched by planes, `_planes.py`. `reference.py` is the plain twin that defines the result of all.
"""

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray
from stereorecal._errors import InputError
from stereorecal.matching._matcher import AbstractMatcher, Disparity, SoftDisparity
from stereorecal.matching._texture import quantise, x_sobel
from stereorecal.matching.sad._kernel import CALL, has_kernel, winners_by_kernel
from stereorecal.matching.sad._planes import winners as winners_by_planes
from stereorecal.matching.sad._soft import soft_search
from stereorecal.matching.sad._stream import (
    NEVER,
    Winners,
    highest_rival_cost,
    index_bits,
    index_of,
    inside_right,
    minimum,
    offsets,
    seen_from_right,
    stream_costs,
    total,
)


@dataclass(frozen=True)
class SAD(AbstractMatcher):
    """Sums of absolute differences over a square window, in JAX; winner takes all, with OpenCV BM's checks.

    Options: see `AbstractMatcher`. `pre_filter_cap=0` matches grey levels without the x-Sobel prefilter. Ties go to
    the smallest disparity; the sub-pixel part is the vertex of the parabola through the three costs at the winner.
    """

    traceable: ClassVar[bool] = True
    smooth: ClassVar[bool] = True

    @property
    def halo(self) -> int:
        """Half a window, and the row that the prefilter looks at beyond it."""
        return self.block_size // 2 + 1

    @property
    def custom_calls(self) -> tuple[str, ...]:
        """The custom calls of XLA in the programs of the search on a CPU; for the cache of traced programs."""
        return (CALL,) if has_kernel() else ()

    def search(self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"]) -> Disparity:
        """See `AbstractMatcher.search`. Pure; can be traced, batched and compiled."""
        self._require_room(left.shape[1])
        return _search(jnp.asarray(left), jnp.asarray(right), self)

    def soft_match(
        self, left: Float[AnyArray, "h w"], right: Float[AnyArray, "h w"], temperature: float | Float[AnyArray, ""]
    ) -> SoftDisparity:
        """See `AbstractMatcher.soft_match`."""
        return soft_search(jnp.asarray(left), jnp.asarray(right), self, temperature)

    def _require_room(self, width: int) -> None:
        """Refuse windows and ranges whose cost and index do not fit into one int32."""
        _, count = self.disparity_range(width)
        if 2 * _largest_cost(self) * 2 ** index_bits(count) >= NEVER:
            raise InputError("block_size and num_disparities are too large together; make one of them smaller.")


@partial(jax.jit, static_argnames="options")
def _search(left: Float[jax.Array, "h w"], right: Float[jax.Array, "h w"], options: SAD) -> Disparity:
    images = quantise(left), quantise(right)
    if options.pre_filter_cap:
        images = tuple(x_sobel(image, options.pre_filter_cap) for image in images)
    # The cache of a core holds the costs of a row; a GPU wants whole images.
    by_rows = partial(winners_by_kernel, largest_cost=_largest_cost(options)) if has_kernel() else winners_by_rows
    on_cpu, elsewhere = (partial(form, options=options) for form in (by_rows, winners_by_planes))
    best = jax.lax.platform_dependent(*images, cpu=on_cpu, default=elsewhere)
    disparity = options.min_disparity + best.winner
    valid = best.cost < NEVER
    # In any case: without this use of the rivals, XLA computes the costs again for each other use, at six times the
    # cost of the search.
    valid &= best.rivals <= (0 if options.uniqueness_ratio else disparity.size)
    if options.disp12_max_diff >= 0:
        width = left.shape[1]
        partner = jnp.clip(jnp.arange(width, dtype=jnp.int32) - disparity, 0, width - 1)
        difference = jnp.abs(jnp.take_along_axis(best.from_right, partner, axis=1) - best.winner)
        valid &= difference <= options.disp12_max_diff
    return Disparity(disparity.astype(jnp.float32) + _parabola(best), valid)


def _parabola(best: Winners) -> Float[jax.Array, "h w"]:
    """Vertex of the parabola through the winner and its neighbours, 0 where a neighbour does not exist."""
    complete = jnp.maximum(best.below, best.above) < NEVER
    below, cost, above = (jnp.where(complete, c, 0).astype(jnp.float32) for c in (best.below, best.cost, best.above))
    curvature = below - 2.0 * cost + above
    return jnp.where(curvature > 0, 0.5 * (below - above) / jnp.where(curvature > 0, curvature, 1.0), 0.0)


def winners_by_rows(left: Int[jax.Array, "h w"], right: Int[jax.Array, "h w"], options: SAD) -> Winners:
    """Best candidates of every pixel of `left`, and of `right` where the left-right check asks for them."""
    width = left.shape[1]
    lowest, count = options.disparity_range(width)
    column = jnp.arange(width, dtype=jnp.int32)
    inside = inside_right(options, width)
    bits, narrow = index_bits(count), _sum_type(options)
    counter = jnp.int16 if count < 2**15 else jnp.int32
    outside = min(int(jnp.iinfo(narrow).max), NEVER >> bits)  # costs more than any candidate

    def packed(cost):
        return (cost.astype(jnp.int32) << bits) | offsets(count)

    def best_of_row(cost):
        cost = jnp.where(inside, cost, narrow.type(outside))
        best = minimum(packed(cost))
        winner, lowest_cost = index_of(best, bits), best >> bits

        def cost_at(i):
            neighbour = cost[jnp.clip(count - 1 - i, 0, count - 1), column].astype(jnp.int32)
            return jnp.where((i >= 0) & (i < count) & (neighbour < outside), neighbour, NEVER)

        below, above = cost_at(winner - 1), cost_at(winner + 1)
        limit = highest_rival_cost(lowest_cost, options.uniqueness_ratio)
        near = sum((c <= limit).astype(jnp.int32) for c in (lowest_cost, below, above))
        limit = jnp.minimum(limit, outside - 1).astype(narrow)
        rivals = total((cost <= limit).astype(counter)).astype(jnp.int32) - near
        from_right = jnp.zeros_like(winner)
        if options.disp12_max_diff >= 0:
            from_right = index_of(minimum(packed(seen_from_right(cost, lowest, outside))), bits)
        return Winners(winner, jnp.where(lowest_cost < outside, lowest_cost, NEVER), rivals, below, above, from_right)

    return stream_costs(left, right, options, narrow, best_of_row)


def _sum_type(options: SAD) -> jnp.dtype:
    """The narrowest integer that holds a window's sum, and one more for what lies outside (int16 overflows from window
    13 on without a prefilter)."""
    return jnp.dtype(jnp.int16 if _largest_cost(options) < 2**15 - 1 else jnp.int32)


def _largest_cost(options: SAD) -> int:
    return (2 * options.pre_filter_cap or 255) * options.block_size**2
