"""The counts of many candidates."""

from functools import partial

import jax
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._correspondences import TILES
from stereorecal.scoring._count import count_scaled
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring.host._cores import on_all_cores
from stereorecal.scoring.host._disparities import disparities

_AT_ONCE = 64  # candidates in one call of a GPU, at most
_PIXELS_AT_ONCE = 2**22  # of them together, which take some hundred bytes each


def counts(data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher) -> Int[np.ndarray, "n"]:
    """The count of each candidate, (n,) int64, for any matcher with `num_disparities` (in full-size pixels).

    A count never depends on how a batch was split. On a CPU each candidate is scored alone, on one core if there are
    several. Elsewhere many are scored together, in batches of at most four sizes.
    """
    if matcher.traceable and jax.default_backend() != "cpu":
        return counts_at_once(data, candidates, matcher)
    return counts_one_by_one(data, candidates, matcher)


def counts_one_by_one(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n"]:
    """`counts` by the programs of `disparities`: nothing more to compile where those are wanted as well."""

    def one(extrinsics: np.ndarray) -> int:
        return sum(int(found.valid.sum()) for found in disparities(data, extrinsics, matcher))

    return np.array(on_all_cores(one, list(np.asarray(candidates, np.float32))), np.int64)


def counts_by_tile(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n k tiles"]:
    """`counts_one_by_one` of each tile of each frame; they add up to the counts."""
    columns, rows = TILES
    width, height = data.view.size
    starts = [np.arange(number) * size // number for number, size in ((rows, height), (columns, width))]

    def one(extrinsics: np.ndarray) -> Int[np.ndarray, "k tiles"]:
        valid = (np.asarray(found.valid) for found in disparities(data, extrinsics, matcher))
        strips = (np.add.reduceat(v, starts[0], axis=0, dtype=np.int64) for v in valid)
        return np.stack([np.add.reduceat(strip, starts[1], axis=1).reshape(-1) for strip in strips])

    return np.stack(on_all_cores(one, list(np.asarray(candidates, np.float32))))


def counts_at_once(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n"]:
    """`counts` in padded batches of at most four sizes: few programs, and wide enough for a GPU."""
    candidates, matcher = np.asarray(candidates, np.float32).reshape(-1, 6), matcher.scaled(data.scale)
    width, height = data.view.size
    size = max(1, min(_AT_ONCE, _PIXELS_AT_ONCE // (width * height)))
    while size >= 4 * len(candidates) > 0:
        size //= 4
    found = [np.zeros(0, np.int64)]
    for first in range(0, len(candidates), size):
        batch = candidates[first : first + size]
        padded = np.concatenate([batch, np.repeat(batch[-1:], size - len(batch), axis=0)])
        found.append(np.asarray(_compiled_counts(data, padded, matcher), np.int64)[: len(batch)])
    return np.concatenate(found)


@partial(jax.jit, static_argnames="matcher")
def _compiled_counts(data: ScoringData, candidates: Float[jax.Array, "n 6"], matcher: AbstractMatcher):
    return jax.vmap(lambda extrinsics: count_scaled(data, extrinsics, matcher))(candidates)
