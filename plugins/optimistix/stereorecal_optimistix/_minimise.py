"""Minimisers, on the negated soft count."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import equinox as eqx
import jax
import numpy as np
import optax
import optimistix as optx
from jaxtyping import Float

from stereorecal.strategies import Need, Traced
from stereorecal_optimistix._chart import Chart, chart_at
from stereorecal_optimistix._climb import AbstractClimb, View
from stereorecal_optimistix._step import Solver

# Equinox compares bare functions by their source code, at every step (10 ms); a Partial it compares directly.
_ADAM = optax.GradientTransformationExtraArgs(*map(jax.tree_util.Partial, optax.adam(1.0)))


@eqx.filter_jit
def look_at_score(score: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> View:
    """Minus the score, with its gradient."""
    value, gradient = jax.value_and_grad(lambda v: -score(chart(v)))(v)
    return View(chart(v), -value, value, gradient)


@dataclass(frozen=True)
class AbstractMinimiser(AbstractClimb):
    """A minimiser: it needs a score with a gradient.

    A count may be a thousand or a million, so the score is divided by the norm of its gradient at the start (with
    respect to first steps): the first step along the gradient then has length `step`, and the later ones shorten with
    the gradient.

    Attributes:
        rtol, atol: the search ends when a step is shorter than rtol times the distance from the start plus atol times
            the first step, and changes the score by less than rtol times the score plus atol times the gain that the
            gradient at the start predicts for the first step.
        steps: the most gradients after the first.
        step: the first step, in half widths of the search box.
    """

    step: float = 1.0 / 16.0

    needs: ClassVar[Need] = Need.SMOOTH

    def look(self, traced: Traced, chart: Chart, v: Float[jax.Array, "n"]) -> View:
        """The soft count with its gradient."""
        assert traced.soft_count is not None  # the core has checked it
        return look_at_score(traced.soft_count, chart, v)

    def chart(self, start: Float[np.ndarray, "n"]) -> Chart:
        """The chart whose unit of length is the first step."""
        return chart_at(start, self.step)


@dataclass(frozen=True)
class BFGS(AbstractMinimiser):
    """BFGS on the soft count: quasi-Newton steps with a backtracking line search.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> Solver:
        """`optimistix.BFGS`."""
        return optx.BFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class LBFGS(AbstractMinimiser):
    """Limited-memory BFGS on the soft count: curvature from the last ten steps only.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> Solver:
        """`optimistix.LBFGS`."""
        return optx.LBFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class NonlinearCG(AbstractMinimiser):
    """Nonlinear conjugate gradients (Polak-Ribière) on the soft count, with a backtracking line search.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: see there; longer by default, since the line search can only shorten a step.
    """

    step: float = 1.0 / 8.0

    def solver(self) -> Solver:
        """`optimistix.NonlinearCG`."""
        return optx.NonlinearCG(self.rtol, self.atol)


@dataclass(frozen=True)
class GradientDescent(AbstractMinimiser):
    """Gradient descent on the soft count, with a fixed learning rate.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: see there; the learning rate is step / |gradient at the start|. Started much closer to the maximum than
            one step, it keeps overshooting.
    """

    steps: int = 300

    def solver(self) -> Solver:
        """`optimistix.GradientDescent`."""
        return optx.GradientDescent(1.0, self.rtol, self.atol)


@dataclass(frozen=True)
class Adam(AbstractMinimiser):
    """Adam (optax) on the soft count: gradient descent with momentum and a step size for each parameter.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: the learning rate: roughly how far each coordinate moves in a step, in half widths of the search box.
    """

    steps: int = 300
    step: float = 1.0 / 64.0

    def solver(self) -> Solver:
        """`optimistix.OptaxMinimiser(optax.adam)`."""
        return optx.OptaxMinimiser(_ADAM, self.rtol, self.atol)
