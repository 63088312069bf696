"""Work spread over the cores in pieces, since XLA runs a row scan on one core: candidates, frames, blocks of rows.

Many candidates of small frames share a program: Python between separate ones would cost as much as they do.
"""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Shaped

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal._compile_cache import cached_program
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._prepare import ScoringData

_here = threading.local()

_ROOM = 32  # candidates in a call, at most

Score = Callable[[ScoringData, Extrinsics, AbstractMatcher], jax.Array]


def cores() -> int:
    """How many cores there are to spread over; 1 where something else than the CPU computes."""
    if jax.default_backend() != "cpu":
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def on_all_cores(function: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
    """`function` of each item, in order; several at a time, unless this is a piece of such work itself."""
    alone = len(items) < 2 or cores() < 2 or getattr(_here, "busy", False)
    return list((map if alone else _workers(os.getpid()).map)(function, items))


@cache
def _workers(process: int) -> ThreadPoolExecutor:
    """One thread for each core; cached, since a search runs many small batches. A fork has none of its parent's."""

    def mark() -> None:
        _here.busy = True

    return ThreadPoolExecutor(cores(), initializer=mark)


def map_candidates(
    score: Score,
    frames: Sequence[ScoringData],
    candidates: Float[AnyArray, "*n 6"],
    matcher: AbstractMatcher,
    keep: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> Shaped[np.ndarray, "k n ..."]:
    """`score(frame, extrinsics, matcher)` of each frame and candidate, on the host. One program serves any number of
    them.

    Args:
        score: pure and traceable; its answer is an array. A function of a module: each new one is compiled.
        frames: of one shape.
        keep: what is kept of the answers to some candidates (n, ...), one row for each of them.
    """
    candidates = np.asarray(candidates, np.float32).reshape(-1, 6)
    calls = -(-cores() // len(frames))  # for each frame
    calls *= max(1, -(-len(candidates) // (calls * _ROOM)))
    parts = [part for part in np.array_split(candidates, calls) if len(part)] or [candidates]

    def evaluated(work: tuple[ScoringData, Float[np.ndarray, "m 6"]]) -> Shaped[np.ndarray, "m ..."]:
        frame, part = work
        padded = np.zeros((_ROOM, 6), np.float32)
        padded[: len(part)] = part
        (answer,) = _evaluated(frame, padded, np.int32(len(part)), score=score, matcher=matcher)
        return keep(np.asarray(answer)[: len(part)])

    answers = on_all_cores(evaluated, [(frame, part) for frame in frames for part in parts])
    return np.stack([np.concatenate(answers[i : i + len(parts)]) for i in range(0, len(answers), len(parts))])


@partial(cached_program, static=("score", "matcher"))
def _evaluated(
    frame: ScoringData, candidates: Float[jax.Array, "m 6"], number, *, score: Score, matcher: AbstractMatcher
):
    answer = jax.eval_shape(lambda extrinsics: score(frame, extrinsics, matcher), candidates[0])
    nothing = jnp.zeros((len(candidates), *answer.shape), answer.dtype)

    def step(i, answers):
        return answers.at[i].set(score(frame, candidates[i], matcher))

    return (jax.lax.fori_loop(0, number, step, nothing),)
