"""Minimisers, on the soft count turned upside down."""

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

# Equinox would compare the source code of bare optax functions at every step (10 ms); a Partial it compares as it is.
_ADAM = optax.GradientTransformationExtraArgs(*map(jax.tree_util.Partial, optax.adam(1.0)))


@eqx.filter_jit
def look_at_score(score: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> View:
    """Minus the score and its gradient, in reverse: the soft count has no other."""
    value, gradient = jax.value_and_grad(lambda v: -score(chart(v)))(v)
    return View(chart(v), -value, value, gradient)


@dataclass(frozen=True)
class AbstractMinimiser(AbstractClimb):
    """A minimiser: it needs a score with a gradient.

    A count can be a thousand or a million, so it is divided by the length of its gradient at the start (in first
    steps): the first step down the gradient then has the length `step`, and later ones are shorter as the gradient is.

    Attributes:
        rtol, atol: the search ends when a step is shorter than rtol of the way from the start plus atol of the first
            step, and changes the score by less than rtol of the score plus atol of what the first step promised.
        steps: the most gradients that it takes after the first.
        step: the first step, in half widths of the search box.
    """

    step: float = 1.0 / 16.0

    needs: ClassVar[Need] = Need.SMOOTH

    def look(self, traced: Traced, chart: Chart, v: Float[jax.Array, "n"]) -> View:
        """At the soft count."""
        assert traced.soft_count is not None  # the core has checked it
        return look_at_score(traced.soft_count, chart, v)

    def chart(self, start: Float[np.ndarray, "n"]) -> Chart:
        """The chart whose unit is the first step."""
        return chart_at(start, self.step)


@dataclass(frozen=True)
class BFGS(AbstractMinimiser):
    """BFGS on the soft count: learns the curvature from gradients, and backtracks where a step promised too much.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> Solver:
        """`optimistix.BFGS`."""
        return optx.BFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class LBFGS(AbstractMinimiser):
    """Limited-memory BFGS on the soft count: the curvature of the last ten steps only.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> Solver:
        """`optimistix.LBFGS`."""
        return optx.LBFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class NonlinearCG(AbstractMinimiser):
    """Nonlinear conjugate gradients (Polak-Ribière) on the soft count, with backtracking.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: as there; its line search only ever shortens a step, so it starts from a longer one.
    """

    step: float = 1.0 / 8.0

    def solver(self) -> Solver:
        """`optimistix.NonlinearCG`."""
        return optx.NonlinearCG(self.rtol, self.atol)


@dataclass(frozen=True)
class GradientDescent(AbstractMinimiser):
    """Gradient descent on the soft count, at a fixed learning rate.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: as there; the learning rate is step / |gradient at the start|. Started much closer to the summit than
            one step, it overshoots for ever.
    """

    steps: int = 300

    def solver(self) -> Solver:
        """`optimistix.GradientDescent`."""
        return optx.GradientDescent(1.0, self.rtol, self.atol)


@dataclass(frozen=True)
class Adam(AbstractMinimiser):
    """Adam (optax) on the soft count: gradient descent with momentum and a step of its own for each parameter.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: the learning rate: about how far each coordinate moves in a step, in half widths of the search box.
    """

    steps: int = 300
    step: float = 1.0 / 64.0

    def solver(self) -> Solver:
        """`optimistix.OptaxMinimiser(optax.adam)`."""
        return optx.OptaxMinimiser(_ADAM, self.rtol, self.atol)
