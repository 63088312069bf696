"""Matching a rectified frame in blocks of rows, on all cores."""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np

from stereorecal._arrays import AnyArray
from stereorecal._compile_cache import cached_program
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._rectify import Rectified
from stereorecal.scoring._validity import match_frame
from stereorecal.scoring.host._cores import cores, on_all_cores

_DEAREST_HALO = 0.1  # of the rows of a block


class Block(NamedTuple):
    """Some rows of a frame: those that a matcher is shown, and which of them are kept."""

    seen: slice
    kept: slice


def match_in_blocks(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    """The disparity of a frame, NumPy arrays."""
    parts = blocks(frame.left.shape[0], matcher)
    if len(parts) == 1:
        return jax.tree.map(np.asarray, _match(matcher, frame))
    rows = jax.tree.map(np.asarray, frame)

    def match(block: Block) -> Disparity:
        found = _match(matcher, jax.tree.map(lambda leaf: leaf[block.seen], rows))
        return jax.tree.map(lambda leaf: np.asarray(leaf)[block.kept], found)

    return jax.tree.map(lambda *found: np.concatenate(found), *on_all_cores(match, parts))


def blocks(height: int, matcher: AbstractMatcher) -> list[Block]:
    """A frame in as many blocks as there are cores, all of one shape, with the matcher's halo on both sides; in fewer
    where the halos would cost more than a tenth, in one if the matcher has none."""
    if matcher.halo is None:
        return [Block(slice(0, height), slice(0, height))]
    halo = max(matcher.halo, matcher.block_size // 2 + 1)  # the core's texture check looks that far
    number = max(1, min(cores(), int(_DEAREST_HALO * height) // (2 * halo)))
    rows = -(-height // number)
    shown = min(height, rows + 2 * halo)

    def block(i: int) -> Block:
        first = min(max(0, i * rows - halo), height - shown)
        return Block(slice(first, first + shown), slice(i * rows - first, min(height, (i + 1) * rows) - first))

    return [block(i) for i in range(number)]


def _match(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    return Disparity(*_compiled_match(frame, matcher=matcher)) if matcher.traceable else match_frame(matcher, frame)


@partial(cached_program, static=("matcher",))
def _compiled_match(frame: Rectified, *, matcher: AbstractMatcher) -> tuple[AnyArray, ...]:
    found = match_frame(matcher, frame)
    return found.values, found.valid
