"""Nelder and Mead's simplex, moved by optimistix on values from the host."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from stereorecal.strategies import Objective, Outcome, Status
from stereorecal_optimistix._best import Best
from stereorecal_optimistix._chart import chart_at
from stereorecal_optimistix._nelder_mead import NelderMead
from stereorecal_optimistix._step import Progress, advance, begin

# Relative; two compiled expressions for the same point may differ in their last bits.
_SAME = 1e-6
# Replaces NaN: worse than any score, and finite in float32.
_NO_VALUE = -1e30


class Answers(eqx.Module):
    """A function known at a few points only: its value there, NaN everywhere else."""

    points: Float[Array, "k n"]
    values: Float[Array, "k"]

    def __call__(self, v: Float[Array, "n"], args: None) -> tuple[Float[Array, ""], None]:
        """The function as optimistix calls it."""
        distance = jnp.abs(self.points - v).max(-1)
        nearest = jnp.argmin(distance)
        known = distance[nearest] <= _SAME * jnp.maximum(1.0, jnp.abs(v).max())
        return jnp.where(known, self.values[nearest], jnp.nan), None


def answers(points: Float[np.ndarray, "k n"], values: Float[np.ndarray, "k"]) -> Answers:
    """Answers padded to one shape, with room for all that a step can evaluate: old corners, two trials, new corners."""
    room = 2 * points.shape[1] + 4 - len(points)
    return Answers(
        jnp.asarray(np.pad(points, ((0, room), (0, 0)), constant_values=np.inf), float),
        jnp.asarray(np.pad(values, (0, room), constant_values=np.nan), float),
    )


def settled_step(
    solver: optx.NelderMead,
    before: Progress,
    ask: Callable[[Float[np.ndarray, "k n"]], Float[np.ndarray, "k"]],
) -> Progress:
    """One step, repeated until every value that it uses is known."""
    known = len(before.v) + 1 if not before.state.first_pass else 0
    points, values = np.asarray(before.state.simplex)[:known], np.asarray(before.state.f_simplex)[:known]
    while True:
        after = advance(solver, answers(points, values), before)
        unknown = np.isnan(after.state.f_simplex)
        if not unknown.any():
            return after
        asked = np.asarray(after.state.simplex)[unknown]
        points, values = np.concatenate([points, asked]), distinct(np.concatenate([values, ask(asked)]))


def distinct(values: Float[np.ndarray, "k"]) -> Float[np.ndarray, "k"]:
    """The values in float32, without ties: each repetition is made a little larger than those before it.

    Optimistix accepts a reflection that ties with the worst corner, so on a plateau of the count it would reflect back
    and forth for ever. A later corner that is no better has to count as worse.
    """
    taken: list[np.float32] = []
    for value in values:
        single = np.float32(value)
        while single in taken:
            single += max(np.spacing(abs(single)), np.finfo(np.float32).tiny)  # XLA flushes subnormals to 0
        taken.append(single)
    return np.array(taken)


class Simplex(optx.NelderMead):
    """`optimistix.NelderMead`, with two bugs of optimistix 0.1.0 fixed.

    Its first simplex is degenerate in three and more dimensions: all but two corners coincide, and no step ever leaves
    their plane. And it looks up the best and the worst corner in the simplex from before the step, so a new corner is
    taken to be where the one it replaced was, and the simplex shrinks towards a point that is not its best.
    """

    def init(self, fn: Any, y: Array, *rest: Any, **named: Any) -> Any:
        """See `optimistix.NelderMead.init`; the first corner is y, the others are one away along each axis."""
        state = super().init(fn, y, *rest, **named)
        edges = jnp.eye(y.size + 1, y.size, k=-1, dtype=y.dtype)
        return eqx.tree_at(lambda s: s.simplex, state, y + edges)

    def step(self, *arguments: Any, **named: Any) -> Any:
        """See `optimistix.NelderMead.step`."""
        y, state, aux = super().step(*arguments, **named)
        corners = state.simplex[state.best[2]], state.simplex[state.worst[2]]
        return y, eqx.tree_at(lambda s: (s.best[1], s.worst[1]), state, corners), aux


def descend(strategy: NelderMead, objective: Objective, start: Float[np.ndarray, "n"]) -> Outcome:
    """Search `objective` from `start`, with the options of `strategy`."""
    chart = chart_at(start, strategy.step)
    solver = Simplex(strategy.rtol, strategy.atol)
    best = Best(start)

    def ask(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        z = chart.on_host(points)
        scores = objective.batch(z)
        scores = np.where(np.isfinite(scores), scores, _NO_VALUE)
        best.see(z[scores.argmax()], scores.max())
        return -scores

    v = jnp.zeros(objective.dim)  # of JAX's default type, as optimistix's own numbers are
    progress = begin(solver, answers(np.zeros((0, objective.dim)), np.zeros(0)), v)
    for _ in range(strategy.steps):
        progress = settled_step(solver, progress, ask)
        if outcome := progress.outcome(best.z):
            return outcome
        if best.score == _NO_VALUE:
            return Outcome(start, Status.STALLED, "the score has no value at the start or one step away from it")
    return Outcome(best.z, Status.STALLED, f"{strategy.steps} steps were not enough")
