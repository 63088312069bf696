"""Frames on the host: rectified, then matched in blocks of rows on all cores, for every matcher; and correspondences,
and the counts of many candidates, by the same programs.
"""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal._compile_cache import CachedProgram
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._correspondences import TILES, Correspondences, gathered, refined
from stereorecal.scoring._count import count_scaled
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._rectify import Rectified, Rotations, match_frame, rectify_frames, rotations_by
from stereorecal.scoring.host._cores import cores, on_all_cores

_LARGEST_HALO = 0.1  # of the rows of a block
_AT_ONCE = 64  # candidates in one call of a GPU, at most
_PIXELS_AT_ONCE = 2**22  # of them together, which take some hundred bytes each

_refined = CachedProgram(refined)


class Block(NamedTuple):
    """Some rows of a frame: the rows that a matcher is given, and which of those are used."""

    given: slice
    used: slice


def disparities(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> list[Disparity]:
    """The disparity of each frame: NumPy arrays, in pixels of the scale of `data`.

    Args:
        matcher: any, with `num_disparities` in full-size pixels.
    """
    return disparities_at(data, compiled_rotations(extrinsics), matcher)


def disparities_at(data: ScoringData, rotations: Rotations, matcher: AbstractMatcher) -> list[Disparity]:
    """`disparities` by rotations into the rectified frame."""
    scaled = matcher.scaled(data.scale)

    def one(frame: ScoringData) -> Disparity:
        return match_in_blocks(scaled, rectified_frame(frame, rotations))

    return on_all_cores(one, data.frames)


def compiled_rotations(extrinsics: Float[AnyArray, "6"]) -> Rotations:
    """The rotations of both cameras into the frame that is rectified by `extrinsics`."""
    return np.asarray(_rotations(np.asarray(extrinsics, np.float32))[0])


@CachedProgram
def _rotations(extrinsics: Extrinsics) -> tuple[jax.Array, ...]:
    return (rotations_by(extrinsics),)


def rectified_frame(data: ScoringData, rotations: Rotations) -> Rectified:
    """The one frame of `data` rectified by `rotations`."""
    return Rectified(*rectified(data, rotations))


@CachedProgram
def rectified(data: ScoringData, rotations: Rotations) -> tuple[jax.Array, ...]:
    """The rectified images and areas of the one frame of `data`, in the order of `Rectified`."""
    frames = rectify_frames(data, rotations, lambda frame: frame)
    return frames.left[0], frames.right[0], frames.left_area[0], frames.right_area[0]


def match_in_blocks(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    """The disparity of a frame, NumPy arrays; its blocks of rows are matched on all cores."""
    parts = blocks(frame.left.shape[0], matcher)
    if len(parts) == 1:
        return jax.tree.map(np.asarray, _match(matcher, frame))
    rows = jax.tree.map(np.asarray, frame)

    def match(block: Block) -> Disparity:
        found = _match(matcher, jax.tree.map(lambda leaf: leaf[block.given], rows))
        return jax.tree.map(lambda leaf: np.asarray(leaf)[block.used], found)

    return jax.tree.map(lambda *found: np.concatenate(found), *on_all_cores(match, parts))


def blocks(height: int, matcher: AbstractMatcher) -> list[Block]:
    """The blocks of a frame, all of one shape, with the matcher's halo on both sides: one for each core; fewer where
    the halos would cost more than a tenth; one if the matcher has no halo."""
    if matcher.halo is None:
        return [Block(slice(0, height), slice(0, height))]
    halo = max(matcher.halo, matcher.block_size // 2 + 1)  # the core's texture check needs that many rows
    number = max(1, min(cores(), int(_LARGEST_HALO * height) // (2 * halo)))
    rows = -(-height // number)
    rows_given = min(height, rows + 2 * halo)

    def block(i: int) -> Block:
        first = min(max(0, i * rows - halo), height - rows_given)
        return Block(slice(first, first + rows_given), slice(i * rows - first, min(height, (i + 1) * rows) - first))

    return [block(i) for i in range(number)]


def _match(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    return Disparity(*_compiled_match(frame, matcher=matcher)) if matcher.traceable else match_frame(matcher, frame)


@partial(CachedProgram, static=("matcher",))
def _compiled_match(frame: Rectified, *, matcher: AbstractMatcher) -> tuple[AnyArray, ...]:
    found = match_frame(matcher, frame)
    return found.values, found.valid


def compile_in_background(data: ScoringData) -> None:
    """Start compiling, in a thread, the programs of `correspondences` for such data, apart from those of rotations and
    match: for a new image size, this takes longer than all stages before it."""
    frame, (width, height) = data.frames[0], data.view.size
    nothing = Disparity(np.zeros((height, width), np.float32), np.zeros((height, width), bool))
    for program, more in ((rectified, ()), (_refined, (of_one(nothing),))):
        program.compile_in_background(frame, np.stack([np.eye(3, dtype=np.float32)] * 2), *more)


def correspondences(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> Correspondences:
    """As `stereorecal.correspondences`; NumPy arrays.

    Args:
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit.
        matcher: any, with `num_disparities` in full-size pixels.
    """
    rotations = compiled_rotations(extrinsics)

    def one(frame: ScoringData) -> tuple[np.ndarray, ...]:
        found = disparities_at(frame, rotations, matcher)[0]
        return tuple(map(np.asarray, _refined(frame, rotations, of_one(found))))

    return gathered(data, *map(np.concatenate, zip(*on_all_cores(one, data.frames), strict=True)))


def of_one(found: Disparity) -> Disparity:
    """The disparity of one frame as that of all: (1, h, w)."""
    return jax.tree.map(lambda leaf: leaf[None], found)


def counts(data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher) -> Int[np.ndarray, "n"]:
    """The count of each candidate, (n,) int64, for any matcher with `num_disparities` (in full-size pixels).

    A count never depends on how a batch was split. On a CPU each candidate is scored alone, on one core if there are
    several. Elsewhere many are scored together, in batches of at most four sizes.
    """
    if matcher.traceable and jax.default_backend() != "cpu":
        return counts_at_once(data, candidates, matcher)
    return counts_by_tile(data, candidates, matcher).sum(axis=(1, 2))


def counts_by_tile(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n k tiles"]:
    """The counts of each tile of each frame, by the programs of `disparities`: nothing more to compile where those are
    wanted as well."""
    columns, rows = TILES
    width, height = data.view.size
    starts = [np.arange(number) * size // number for number, size in ((rows, height), (columns, width))]

    def tiles(candidate: Float[np.ndarray, "6"]) -> Int[np.ndarray, "k tiles"]:
        valid = (np.asarray(one.valid) for one in disparities(data, candidate, matcher))
        strips = (np.add.reduceat(one, starts[0], axis=0, dtype=np.int64) for one in valid)
        return np.stack([np.add.reduceat(strip, starts[1], axis=1).reshape(-1) for strip in strips])

    found = on_all_cores(tiles, list(np.asarray(candidates, np.float32)))
    return np.array(found, np.int64).reshape(-1, len(data.left), columns * rows)


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
