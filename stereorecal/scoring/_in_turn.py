"""Many candidates, one after the other in one program, and a call of it on each core: where frames are small, Python
between the programs of each candidate would cost as much as they do."""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import AnyArray, Extrinsics
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring._cores import cores, on_all_cores
from stereorecal.scoring._data import ScoringData

_ROOM = 32  # candidates in a call, at most

Look = Callable[[ScoringData, Extrinsics, AbstractMatcher], jax.Array]


def in_turn(
    look: Look, data: ScoringData, candidates: Float[AnyArray, "n 6"], matcher: AbstractMatcher
) -> Int[np.ndarray, "n ..."]:
    """`look(data, extrinsics, matcher)` of each candidate, on the host. One program serves any number of them.

    Args:
        look: pure and traceable; its answer is an array of whole numbers.
    """
    candidates = np.asarray(candidates, np.float32).reshape(-1, 6)
    calls = max(1, cores(), -(-len(candidates) // _ROOM))
    parts = [part for part in np.array_split(candidates, calls) if len(part)]

    def seen(part: Float[np.ndarray, "m 6"]) -> Int[np.ndarray, "m ..."]:
        padded = np.zeros((_ROOM, 6), np.float32)
        padded[: len(part)] = part
        return np.asarray(_seen(look, data, padded, np.int32(len(part)), matcher))[: len(part)]

    return np.concatenate(on_all_cores(seen, parts or [candidates]))


@partial(jax.jit, static_argnames=("look", "matcher"))
def _seen(look: Look, data: ScoringData, candidates: Float[jax.Array, "m 6"], number, matcher: AbstractMatcher):
    answer = jax.eval_shape(lambda extrinsics: look(data, extrinsics, matcher), candidates[0])
    nothing = jnp.zeros((len(candidates), *answer.shape), answer.dtype)
    return jax.lax.fori_loop(0, number, lambda i, seen: seen.at[i].set(look(data, candidates[i], matcher)), nothing)
