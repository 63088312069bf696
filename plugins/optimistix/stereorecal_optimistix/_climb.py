"""The loop on the host that all derivative-based solvers share."""

import abc
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome, Status, Traced
from stereorecal_optimistix._best import Best
from stereorecal_optimistix._chart import Chart, chart_at
from stereorecal_optimistix._options import check_options
from stereorecal_optimistix._step import Solver, Tangent, advance, begin


class View(eqx.Module):
    """One evaluation with its derivative.

    Attributes:
        z: the point, in the box.
        score: the score there, to be maximised.
        value: what the solver minimises: minus the score, or the residuals, up to an orthogonal transformation.
        slope: its derivative with respect to the solver's coordinates v, transformed alike.
    """

    z: Float[Array, "n"]
    score: Float[Array, ""]
    value: Float[Array, "*m"]
    slope: Float[Array, "*m n"]


@dataclass(frozen=True)
class AbstractClimb(AbstractStrategy):
    """A solver that evaluates one value with its derivative per step.

    Attributes:
        rtol, atol: the search ends when a step changes both v and the value by less than atol + rtol times their size.
        steps: the most steps, rejected ones included.
    """

    rtol: float = 1e-3
    atol: float = 1e-3
    steps: int = 100

    def __post_init__(self) -> None:
        check_options(self)

    @abc.abstractmethod
    def solver(self) -> Solver:
        """The solver of optimistix."""

    @abc.abstractmethod
    def look(self, traced: Traced, chart: Chart, v: Float[Array, "n"]) -> View:
        """The value and its derivative at v, in one compiled call."""

    def chart(self, start: Float[np.ndarray, "n"]) -> Chart:
        """The map from the solver's coordinates v to the box."""
        return chart_at(start)

    def scale(self, first: View) -> float:
        """What the solver's function is divided by, so that the options do not depend on the score's unit."""
        return float(np.linalg.norm(np.asarray(first.slope, float)))

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        solver, chart, best = self.solver(), self.chart(start), Best(start)
        cost = objective.gradient_cost

        def look(v: jax.Array) -> View:
            objective.reserve(cost)
            view = self.look(objective.traced, chart, v)
            best.see(np.asarray(view.z, float), float(view.score))
            objective.charge(cost, best=best.z)
            return view

        v = jnp.asarray(np.zeros(objective.dim))  # of JAX's default type, as optimistix's own numbers are
        view = look(v)
        scale = self.scale(view)
        if not 0.0 < scale < np.inf:
            slope = "vanishes" if scale == 0.0 else "is not finite"
            return Outcome(best.z, Status.STALLED, f"the derivative {slope} at the start")
        tangent = Tangent(v, view.value, view.slope, jnp.asarray(scale))
        progress = begin(solver, tangent, v)
        for _ in range(self.steps):
            progress = advance(solver, tangent, progress)
            if outcome := progress.outcome(best.z):
                return outcome
            v = progress.next
            if not np.isfinite(np.asarray(v)).all():
                return Outcome(best.z, Status.STALLED, "the score or its derivative is not finite at the last point")
            view = look(v)
            tangent = Tangent(v, view.value, view.slope, tangent.scale)
        return Outcome(best.z, Status.STALLED, f"{self.steps} steps were not enough")
