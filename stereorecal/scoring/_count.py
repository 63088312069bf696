"""The paper's score: the number of pixels with a valid disparity."""

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._data import Rectified, ScoringData, rectified_frames, rectify_frames
from stereorecal.scoring._validity import match_frame


def count(data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher) -> Int[jax.Array, ""]:
    """f(I_l, I_r, Υ) of the paper (eq. 2), summed over the frames. Pure and traceable; for traceable matchers.

    Args:
        extrinsics: (6,) float32: pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.
        matcher: with its disparity range at the scale of `data`.
    """

    def valid_pixels(frame: Rectified) -> jax.Array:
        return jnp.sum(match_frame(matcher, frame).valid, dtype=jnp.int32)

    return jnp.sum(rectify_frames(data, extrinsics, valid_pixels), dtype=jnp.int32)


_compiled_count = jax.jit(count, static_argnames="matcher")


def counts(data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher) -> Int[np.ndarray, "n"]:
    """The count of each candidate, (n,) int64 on the host, for any matcher.

    One program serves every batch size, so a count never depends on how a batch was split.
    """
    candidates = np.asarray(candidates, np.float32)

    def one(extrinsics: np.ndarray) -> int:
        if matcher.traceable:
            return int(_compiled_count(data, extrinsics, matcher))
        return sum(int(d.valid.sum()) for d in disparities(data, extrinsics, matcher))

    # XLA runs one row scan on one core; candidates are what there is to spread.
    spread = len(candidates) > 1 and jax.default_backend() == "cpu"
    return np.array(list((_workers().map if spread else map)(one, candidates)), np.int64)


@cache
def _workers() -> ThreadPoolExecutor:
    """One thread for each core; kept, since a search asks for many small batches."""
    return ThreadPoolExecutor(os.cpu_count() or 1)


def disparities(data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher) -> list[Disparity]:
    """The disparity of each frame under one set of extrinsics, NumPy arrays."""
    frames = jax.tree.map(np.asarray, rectified_frames(data, jnp.asarray(extrinsics, jnp.float32)))
    count = data.left.shape[0]
    return [
        jax.tree.map(np.asarray, _match(matcher, jax.tree.map(lambda leaf, i=i: leaf[i], frames))) for i in range(count)
    ]


def _match(matcher: AbstractMatcher, frame: Rectified) -> Disparity:
    return _compiled_match(matcher, frame) if matcher.traceable else match_frame(matcher, frame)


_compiled_match = jax.jit(match_frame, static_argnames="matcher")
