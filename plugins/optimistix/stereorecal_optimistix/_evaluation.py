"""Evaluations with their derivatives, each in one compiled call."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from stereorecal.strategies import Need, Traced
from stereorecal_optimistix._chart import Chart

_BLOCK = 128  # rows; small enough for OpenBLAS to stay on one thread


class Evaluation(eqx.Module):
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


def evaluated(needs: Need, traced: Traced, chart: Chart, v: Float[Array, "n"]) -> Evaluation:
    """The face of the objective that a strategy needs, at v."""
    if needs is Need.RESIDUALS:
        assert traced.residuals is not None  # the core has checked it
        return evaluated_residuals(traced.residuals, chart, v)
    assert traced.soft_count is not None
    return evaluated_score(traced.soft_count, chart, v)


@eqx.filter_jit
def evaluated_score(score: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> Evaluation:
    """Minus the score, with its gradient."""
    value, gradient = jax.value_and_grad(lambda v: -score(chart(v)))(v)
    return Evaluation(chart(v), -value, value, gradient)


@eqx.filter_jit
def evaluated_residuals(residuals: Callable[[jax.Array], jax.Array], chart: Chart, v: jax.Array) -> Evaluation:
    """The residuals and their Jacobian, in forward mode: there are many more residuals than parameters.

    Both are reduced by the same orthogonal transformation (QR) to n + 1 rows. That preserves lengths and angles, so a
    solver takes the same steps on a few numbers, and is compiled once for any number of residuals above n.
    """

    def along(direction: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jax.jvp(lambda v: residuals(chart(v)), (v,), (direction,))

    value, jacobian = jax.vmap(along, out_axes=(None, -1))(jnp.eye(v.size, dtype=v.dtype))
    turned = triangle(jnp.column_stack([jacobian, value]))
    return Evaluation(chart(v), -0.5 * (value**2).sum(), turned[:, -1], turned[:, :-1])


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
