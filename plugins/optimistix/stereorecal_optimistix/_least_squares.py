"""Least-squares solvers, on the residuals."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from stereorecal.strategies import Need, Traced
from stereorecal_optimistix._chart import Chart
from stereorecal_optimistix._climb import AbstractClimb, View
from stereorecal_optimistix._step import Solver

_BLOCK = 128  # rows; small enough for OpenBLAS to stay on one thread


@eqx.filter_jit
def look_at_residuals(residuals: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> View:
    """The residuals and their Jacobian, in forward mode: there are many more residuals than parameters.

    Both are reduced by the same orthogonal transformation (QR) to n + 1 rows. That preserves lengths and angles, so a
    solver takes the same steps on a few numbers, and is compiled once for any number of residuals above n.
    """

    def along(direction: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jax.jvp(lambda v: residuals(chart(v)), (v,), (direction,))

    value, jacobian = jax.vmap(along, out_axes=(None, -1))(jnp.eye(v.size, dtype=v.dtype))
    turned = triangle(jnp.column_stack([jacobian, value]))
    return View(chart(v), -0.5 * (value**2).sum(), turned[:, -1], turned[:, :-1])


def triangle(rows: Float[Array, "m k"]) -> Float[Array, "r k"]:
    """R of the QR decomposition, with a non-negative diagonal; r = min(m, k).

    Computed by blocks of rows (TSQR: Demmel et al. 2012): on all rows at once OpenBLAS starts its threads, and now and
    then waits for them ten times as long as the work takes.
    """
    missing = -len(rows) % _BLOCK if len(rows) > _BLOCK else 0
    blocks = jnp.pad(rows, ((0, missing), (0, 0))).reshape(-1, min(len(rows), _BLOCK), rows.shape[1])
    of_blocks = jnp.linalg.qr(blocks, mode="r")
    whole = jnp.linalg.qr(of_blocks.reshape(-1, rows.shape[1]), mode="r")
    return jnp.where(jnp.diag(whole)[:, None] < 0.0, -whole, whole)


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

    def look(self, traced: Traced, chart: Chart, v: Float[Array, "n"]) -> View:
        """The residuals and their Jacobian."""
        assert traced.residuals is not None  # the core has checked it
        return look_at_residuals(traced.residuals, chart, v)

    def scale(self, first: View) -> float:
        """The root mean square of the norms of the Jacobian's columns."""
        return float(np.sqrt((np.asarray(first.slope, float) ** 2).sum(0).mean()))


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

    def scale(self, first: View) -> float:
        """The scale of `AbstractLeastSquares` times √damping: optimistix always starts with a damping of 1."""
        return super().scale(first) * self.damping**0.5

    def solver(self) -> Solver:
        """`optimistix.LevenbergMarquardt`."""
        return optx.LevenbergMarquardt(self.rtol, self.atol)


@dataclass(frozen=True)
class GaussNewton(AbstractLeastSquares):
    """Gauss-Newton on the residuals: always the full step, undamped.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> Solver:
        """`optimistix.GaussNewton`."""
        return optx.GaussNewton(self.rtol, self.atol)


@dataclass(frozen=True)
class Dogleg(AbstractLeastSquares):
    """Powell's dogleg on the residuals: Gauss-Newton and steepest descent within a trust region.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> Solver:
        """`optimistix.Dogleg`."""
        return optx.Dogleg(self.rtol, self.atol)
