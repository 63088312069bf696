"""The loop on the host that all derivative-based solvers share."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Objective, Outcome, Status
from stereorecal_optimistix._best import Best
from stereorecal_optimistix._chart import chart_at
from stereorecal_optimistix._climb import AbstractClimb
from stereorecal_optimistix._evaluation import Evaluation, evaluated
from stereorecal_optimistix._step import Tangent, advance, begin


def climb(strategy: AbstractClimb, objective: Objective, start: Float[np.ndarray, "n"]) -> Outcome:
    """Climb `objective` from `start`, with the solver and the options of `strategy`."""
    solver, chart, best = strategy.solver(), chart_at(start, strategy.unit), Best(start)
    cost = objective.gradient_cost

    def seen(v: jax.Array) -> Evaluation:
        objective.reserve(cost)
        view = evaluated(strategy.needs, objective.traced, chart, v)
        best.see(np.asarray(view.z, float), float(view.score))
        objective.charge(cost, best=best.z)
        return view

    v = jnp.asarray(np.zeros(objective.dim))  # of JAX's default type, as optimistix's own numbers are
    view = seen(v)
    scale = strategy.scale(np.asarray(view.slope, float))
    if not 0.0 < scale < np.inf:
        slope = "vanishes" if scale == 0.0 else "is not finite"
        return Outcome(best.z, Status.STALLED, f"the derivative {slope} at the start")
    tangent = Tangent(v, view.value, view.slope, jnp.asarray(scale))
    progress = begin(solver, tangent, v)
    for _ in range(strategy.steps):
        progress = advance(solver, tangent, progress)
        if outcome := progress.outcome(best.z):
            return outcome
        v = progress.next
        if not np.isfinite(np.asarray(v)).all():
            return Outcome(best.z, Status.STALLED, "the score or its derivative is not finite at the last point")
        view = seen(v)
        tangent = Tangent(v, view.value, view.slope, tangent.scale)
    return Outcome(best.z, Status.STALLED, f"{strategy.steps} steps were not enough")
