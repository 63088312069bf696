"""A score of many candidates, one after the other in one program, and a call of the program on each core.

On small frames, Python between separate programs for each candidate would cost as much as the programs.
"""

from collections.abc import Callable, Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Shaped

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal._compile_cache import cached_program
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring.host._cores import cores, on_all_cores

_ROOM = 32  # candidates in a call, at most

Score = Callable[[ScoringData, Extrinsics, AbstractMatcher], jax.Array]


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
