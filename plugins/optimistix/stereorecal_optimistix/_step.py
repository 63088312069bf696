"""A solver of optimistix, stepped from outside: each step is given the values that it would have evaluated."""

from typing import Any

import equinox as eqx
import jax
import optimistix as optx
from jaxtyping import Array, Float

from stereorecal.strategies import Outcome, Status

Solver = optx.AbstractMinimiser | optx.AbstractLeastSquaresSolver
_NO_TAGS: frozenset[object] = frozenset()


class Tangent(eqx.Module):
    """The first-order Taylor expansion of a function at one point.

    A step of a solver evaluates the function and its derivative at one point only, so it cannot tell the difference.

    Attributes:
        point: where the function was evaluated.
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
    """The state of a solver between two steps."""

    v: Float[Array, "n"]
    state: Any
    done: Array
    failed: Array
    result: optx.RESULTS

    @property
    def next(self) -> Float[Array, "n"]:
        """Where the next step evaluates the function."""
        # Line searches and trust regions evaluate a trial point ahead of the accepted one; OptaxMinimiser does not.
        return getattr(self.state, "y_eval", self.v)

    def outcome(self, best: Any) -> Outcome | None:
        """How the solver ended, or None if it goes on."""
        if bool(self.failed):
            return Outcome(best, Status.STALLED, f"optimistix: {optx.RESULTS[self.result].partition('. ')[0]}")
        if bool(self.done):
            return Outcome(best, Status.CONVERGED)
        return None


@eqx.filter_jit
def begin(solver: Solver, answer: Any, v: Float[Array, "n"]) -> Progress:
    """The solver at v, before its first step; only the shape of `answer` is used."""
    shape, nothing = eqx.filter_eval_shape(answer, v, None)
    state = solver.init(answer, v, None, {}, shape, nothing, _NO_TAGS)
    return _progress(solver, answer, v, state)


@eqx.filter_jit
def advance(solver: Solver, answer: Any, progress: Progress) -> Progress:
    """One step, given `answer` at the point that the step before it asked for."""
    with jax.default_matmul_precision("highest"):  # else a GPU multiplies with a mantissa of ten bits (TF32)
        v, state, _ = solver.step(answer, progress.v, None, {}, progress.state, _NO_TAGS)
        return _progress(solver, answer, v, state)


def _progress(solver: Solver, answer: Any, v: Float[Array, "n"], state: Any) -> Progress:
    done, result = solver.terminate(answer, v, None, {}, state, _NO_TAGS)
    return Progress(v, state, done, result != optx.RESULTS.successful, result)
