"""The paper's score: the number of pixels with a valid disparity."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._blocks import match_in_blocks
from stereorecal.scoring._cores import on_all_cores
from stereorecal.scoring._in_turn import in_turn
from stereorecal.scoring._prepare import Rectified, ScoringData, rectified_frame, rectify_frames
from stereorecal.scoring._validity import match_frame

_SMALL = 2**16  # pixels of a frame: its programs are then so short that candidates share a call of one
_AT_ONCE = 64  # candidates in one call of a GPU, at most
_PIXELS_AT_ONCE = 2**22  # of them together, which take some hundred bytes each


def count(data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher) -> Int[jax.Array, ""]:
    """f(I_l, I_r, Υ) of the paper (eq. 2), summed over the frames. Pure and traceable; for traceable matchers.

    Args:
        extrinsics: (6,) float32: pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: with its disparity range at the scale of `data`.
    """

    def valid_pixels(frame: Rectified) -> jax.Array:
        return jnp.sum(match_frame(matcher, frame).valid, dtype=jnp.int32)

    return jnp.sum(rectify_frames(data, extrinsics, valid_pixels), dtype=jnp.int32)


def counts(data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher) -> Int[np.ndarray, "n"]:
    """The count of each candidate, (n,) int64 on the host, for any matcher.

    A count never depends on how a batch was split. On a CPU each candidate is looked at alone, on one core if there are
    several: on small frames many in a call of one program, on large ones by the programs of `disparities`. Elsewhere so
    many are looked at together, in one program.
    """
    if matcher.traceable and jax.default_backend() != "cpu":
        return counts_at_once(data, candidates, matcher)
    if not matcher.traceable or data.view.size[0] * data.view.size[1] > _SMALL:
        return counts_one_by_one(data, candidates, matcher)
    return in_turn(count, data.frames, candidates, matcher).sum(axis=0, dtype=np.int64)


def counts_one_by_one(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n"]:
    """`counts` by the programs of `disparities`: nothing more to compile where those are wanted as well."""

    def one(extrinsics: np.ndarray) -> int:
        return sum(int(found.valid.sum()) for found in disparities(data, extrinsics, matcher))

    return np.array(on_all_cores(one, list(np.asarray(candidates, np.float32))), np.int64)


def counts_at_once(
    data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n"]:
    """`counts` in batches of one size, padded: one program, wide enough for a GPU."""
    candidates = np.asarray(candidates, np.float32).reshape(-1, 6)
    width, height = data.view.size
    size = max(1, min(_AT_ONCE, _PIXELS_AT_ONCE // (width * height)))
    found = [np.zeros(0, np.int64)]
    for first in range(0, len(candidates), size):
        batch = candidates[first : first + size]
        padded = np.concatenate([batch, np.repeat(batch[-1:], size - len(batch), axis=0)])
        found.append(np.asarray(_compiled_counts(data, padded, matcher), np.int64)[: len(batch)])
    return np.concatenate(found)


@partial(jax.jit, static_argnames="matcher")
def _compiled_counts(data: ScoringData, candidates: Float[jax.Array, "n 6"], matcher: AbstractMatcher):
    return jax.vmap(lambda extrinsics: count(data, extrinsics, matcher))(candidates)


def disparities(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> list[Disparity]:
    """The disparity of each frame under one set of extrinsics, NumPy arrays."""
    single = np.asarray(extrinsics, np.float32)

    def one(frame: ScoringData) -> Disparity:
        return match_in_blocks(matcher, rectified_frame(frame, single))

    return on_all_cores(one, data.frames)
