"""A solver of optimistix, stepped by hand: every step is given the answer that it would have asked a function for."""

from typing import Any

import equinox as eqx
import jax
import optimistix as optx
from jaxtyping import Array, Float

from stereorecal.strategies import Outcome, Status

Solver = optx.AbstractMinimiser | optx.AbstractLeastSquaresSolver
_NO_TAGS: frozenset[object] = frozenset()


class Tangent(eqx.Module):
    """What is known of a function at one point, as a function: its tangent there.

    A step of a solver asks for the value and the derivative at one point only, so the tangent is all that it can see.

    Attributes:
        point: where the function was asked.
        value: a scalar, or a vector of residuals.
        slope: its gradient, or its Jacobian.
        scale: value and slope are divided by it.
    """

    point: Float[Array, "n"]
    value: Float[Array, "*m"]
    slope: Float[Array, "*m n"]
    scale: Float[Array, ""]

    def __call__(self, v: Float[Array, "n"], args: None) -> tuple[Float[Array, "*m"], None]:
        """The function as optimistix calls it."""
        return (self.value + self.slope @ (v - self.point)) / self.scale, None


class Progress(eqx.Module):
    """A solver between two steps."""

    v: Float[Array, "n"]
    state: Any
    done: Array
    failed: Array
    result: optx.RESULTS

    @property
    def next(self) -> Float[Array, "n"]:
        """Where the next step wants to look."""
        # Line searches and trust regions look ahead of the point that they stand on; OptaxMinimiser does not.
        return getattr(self.state, "y_eval", self.v)

    def outcome(self, best: Any) -> Outcome | None:
        """How the solver ended, None if it goes on."""
        if bool(self.failed):
            return Outcome(best, Status.STALLED, f"optimistix: {optx.RESULTS[self.result].partition('. ')[0]}")
        if bool(self.done):
            return Outcome(best, Status.CONVERGED)
        return None


@eqx.filter_jit
def begin(solver: Solver, answer: Any, v: Float[Array, "n"]) -> Progress:
    """The solver at v, before its first step; uses only the shape of the answer."""
    shape, nothing = eqx.filter_eval_shape(answer, v, None)
    state = solver.init(answer, v, None, {}, shape, nothing, _NO_TAGS)
    return _progress(solver, answer, v, state)


@eqx.filter_jit
def advance(solver: Solver, answer: Any, progress: Progress) -> Progress:
    """One step, taken on the answer to what the step before it wanted to know."""
    with jax.default_matmul_precision("highest"):  # a GPU would multiply the Jacobian with ten bits
        v, state, _ = solver.step(answer, progress.v, None, {}, progress.state, _NO_TAGS)
        return _progress(solver, answer, v, state)


def _progress(solver: Solver, answer: Any, v: Float[Array, "n"], state: Any) -> Progress:
    done, result = solver.terminate(answer, v, None, {}, state, _NO_TAGS)
    return Progress(v, state, done, result != optx.RESULTS.successful, result)
