"""Minimisers, on the negated soft count."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stereorecal.strategies import Need
from stereorecal_optimistix._climb import AbstractClimb
from stereorecal_optimistix._importing import importing

if TYPE_CHECKING:
    from stereorecal_optimistix._step import Solver


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

    @property
    def unit(self) -> float:
        """The first step."""
        return self.step


@dataclass(frozen=True)
class BFGS(AbstractMinimiser):
    """BFGS on the soft count: quasi-Newton steps with a backtracking line search.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> "Solver":
        """`optimistix.BFGS`."""
        import optimistix as optx

        return optx.BFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class LBFGS(AbstractMinimiser):
    """Limited-memory BFGS on the soft count: curvature from the last ten steps only.

    Attributes:
        rtol, atol, steps, step: see `AbstractMinimiser`.
    """

    def solver(self) -> "Solver":
        """`optimistix.LBFGS`."""
        import optimistix as optx

        return optx.LBFGS(self.rtol, self.atol)


@dataclass(frozen=True)
class NonlinearCG(AbstractMinimiser):
    """Nonlinear conjugate gradients (Polak-Ribière) on the soft count, with a backtracking line search.

    Attributes:
        rtol, atol, steps: see `AbstractMinimiser`.
        step: see there; longer by default, since the line search can only shorten a step.
    """

    step: float = 1.0 / 8.0

    def solver(self) -> "Solver":
        """`optimistix.NonlinearCG`."""
        import optimistix as optx

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

    def solver(self) -> "Solver":
        """`optimistix.GradientDescent`."""
        import optimistix as optx

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

    def solver(self) -> "Solver":
        """`optimistix.OptaxMinimiser(optax.adam)`."""
        import optimistix as optx

        with importing(self):
            from stereorecal_optimistix._adam import ADAM
        return optx.OptaxMinimiser(ADAM, self.rtol, self.atol)
