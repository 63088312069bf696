"""Least-squares solvers, on the residuals."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Need
from stereorecal_optimistix._climb import AbstractClimb

if TYPE_CHECKING:
    from stereorecal_optimistix._step import Solver


@dataclass(frozen=True)
class AbstractLeastSquares(AbstractClimb):
    """A least-squares solver: it needs residuals.

    They are divided by the root mean square of the norms of the Jacobian's columns at the start, so that moving by half
    the width of the box changes them by about one, and tolerances mean the same for both.

    Attributes:
        rtol, atol: the search ends when a step is shorter than atol + rtol times the distance from the start, in half
            widths of the box, and changes no component of the scaled residuals (n along the columns of the Jacobian,
            and the norm of the rest) by more than atol + rtol times its size.
        steps: the most Jacobians after the first.
    """

    steps: int = 50

    needs: ClassVar[Need] = Need.RESIDUALS

    def scale(self, slope: Float[np.ndarray, "m n"]) -> float:
        """The root mean square of the norms of the Jacobian's columns."""
        return float(np.sqrt((slope**2).sum(0).mean()))


@dataclass(frozen=True)
class LevenbergMarquardt(AbstractLeastSquares):
    """Levenberg-Marquardt on the residuals: Gauss-Newton with adaptive damping.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
        damping: the initial damping, relative to the mean of the diagonal of JᵀJ. Optimistix divides it by 3.5 after
            every accepted step and multiplies it by 4 after every rejected one; choose 1 or more where the start is
            poor. The residuals, which `rtol` and `atol` refer to, are also divided by its square root.
    """

    damping: float = 0.01

    def scale(self, slope: Float[np.ndarray, "m n"]) -> float:
        """The scale of `AbstractLeastSquares` times √damping: optimistix always starts with a damping of 1."""
        return super().scale(slope) * self.damping**0.5

    def solver(self) -> "Solver":
        """`optimistix.LevenbergMarquardt`."""
        import optimistix as optx

        return optx.LevenbergMarquardt(self.rtol, self.atol)


@dataclass(frozen=True)
class GaussNewton(AbstractLeastSquares):
    """Gauss-Newton on the residuals: always the full step, undamped.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> "Solver":
        """`optimistix.GaussNewton`."""
        import optimistix as optx

        return optx.GaussNewton(self.rtol, self.atol)


@dataclass(frozen=True)
class Dogleg(AbstractLeastSquares):
    """Powell's dogleg on the residuals: Gauss-Newton and steepest descent within a trust region.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> "Solver":
        """`optimistix.Dogleg`."""
        import optimistix as optx

        return optx.Dogleg(self.rtol, self.atol)
