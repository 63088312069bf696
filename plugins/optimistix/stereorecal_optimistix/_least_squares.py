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

_BLOCK = 128  # rows


@eqx.filter_jit
def look_at_residuals(residuals: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> View:
    """The residuals and their Jacobian, forward: there are many more rows than parameters.

    Both are turned together (QR), so that only the first n + 1 rows are not 0. That changes no length and no angle, so
    a solver takes the same steps, on a few numbers, and is compiled once for any number of residuals above n.
    """

    def along(direction: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jax.jvp(lambda v: residuals(chart(v)), (v,), (direction,))

    value, jacobian = jax.vmap(along, out_axes=(None, -1))(jnp.eye(v.size, dtype=v.dtype))
    turned = triangle(jnp.column_stack([jacobian, value]))
    return View(chart(v), -0.5 * (value**2).sum(), turned[:, -1], turned[:, :-1])


def triangle(rows: Float[Array, "m k"]) -> Float[Array, "r k"]:
    """R of the QR decomposition, its diagonal not negative; r = min(m, k).

    By blocks of rows (TSQR: Demmel et al. 2012): given all rows at once, OpenBLAS wakes its threads, and now and then
    waits for them ten times longer than the work takes.
    """
    missing = -len(rows) % _BLOCK if len(rows) > _BLOCK else 0
    blocks = jnp.pad(rows, ((0, missing), (0, 0))).reshape(-1, min(len(rows), _BLOCK), rows.shape[1])
    of_blocks = jnp.linalg.qr(blocks, mode="r")
    whole = jnp.linalg.qr(of_blocks.reshape(-1, rows.shape[1]), mode="r")
    return jnp.where(jnp.diag(whole)[:, None] < 0.0, -whole, whole)


@dataclass(frozen=True)
class AbstractLeastSquares(AbstractClimb):
    """A least-squares solver: it needs residuals.

    They are divided by the root mean square of the Jacobian's columns at the start, so that moving by the half width of
    the box changes them by about one, and tolerances mean the same for both.

    Attributes:
        rtol, atol: the search ends when a step moves by less than atol + rtol times the way from the start, in half
            widths of the box, and changes no component of the residuals by more than atol + rtol times its size, in
            the unit above: n of them along the columns of the Jacobian, and the length of the rest.
        steps: the most Jacobians that it takes after the first.
    """

    steps: int = 50

    needs: ClassVar[Need] = Need.RESIDUALS

    def look(self, traced: Traced, chart: Chart, v: Float[Array, "n"]) -> View:
        """At the residuals."""
        assert traced.residuals is not None  # the core has checked it
        return look_at_residuals(traced.residuals, chart, v)

    def scale(self, first: View) -> float:
        """The root mean square of the lengths of the Jacobian's columns."""
        return float(np.sqrt((np.asarray(first.slope, float) ** 2).sum(0).mean()))


@dataclass(frozen=True)
class LevenbergMarquardt(AbstractLeastSquares):
    """Levenberg-Marquardt on the residuals: Gauss-Newton, damped as much as it takes to go down.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
        damping: at the start, relative to the mean diagonal of JᵀJ. Every good step divides it by 3.5 and every bad one
            multiplies it by 4; give 1 or more where the start is poor. The unit of the residuals, which `rtol` and
            `atol` refer to, is that of `AbstractLeastSquares` times the root of it.
    """

    damping: float = 0.01

    def scale(self, first: View) -> float:
        """As above; optimistix starts with a damping of 1, so the unit of the residuals is what sets it."""
        return super().scale(first) * self.damping**0.5

    def solver(self) -> Solver:
        """`optimistix.LevenbergMarquardt`."""
        return optx.LevenbergMarquardt(self.rtol, self.atol)


@dataclass(frozen=True)
class GaussNewton(AbstractLeastSquares):
    """Gauss-Newton on the residuals: always the full step, with nothing to hold it back.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> Solver:
        """`optimistix.GaussNewton`."""
        return optx.GaussNewton(self.rtol, self.atol)


@dataclass(frozen=True)
class Dogleg(AbstractLeastSquares):
    """Powell's dogleg on the residuals: Gauss-Newton within a trust region, else down the gradient first.

    Attributes:
        rtol, atol, steps: see `AbstractLeastSquares`.
    """

    def solver(self) -> Solver:
        """`optimistix.Dogleg`."""
        return optx.Dogleg(self.rtol, self.atol)
