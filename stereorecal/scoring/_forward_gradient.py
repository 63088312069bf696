"""Derivatives by forward mode alone, for scores whose reverse pass would keep every matching cost."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero

from stereorecal._arrays import product
from stereorecal._errors import InputError

TracedScore = Callable[[Any, jax.Array], jax.Array]


def forward_gradient(score: TracedScore, with_derivatives: TracedScore | None = None) -> TracedScore:
    """The same `score(data, z)`, z (n,), differentiable in every mode with respect to z; data counts as constant.

    A derivative takes n forward derivatives side by side and keeps only the (n,) gradient: no tape, about n + 1 times
    the work of the score, in reverse (`grad`) as in forward mode (`jvp`, `jacfwd`).

    Args:
        with_derivatives: what to differentiate instead, if it should differ from what is evaluated.
    """
    differentiated = with_derivatives or score

    @jax.custom_jvp
    def differentiable(data, z):
        return score(data, z)

    def rule(primals, tangents):
        (data, z), (of_data, direction) = primals, tangents
        if any(not isinstance(leaf, SymbolicZero) for leaf in jax.tree.leaves(of_data)):
            raise InputError(
                "the score has derivatives with respect to its point only; differentiate with respect to the "
                "extrinsics, and close over data, matcher and temperature."
            )

        def along(unit):
            return jax.jvp(lambda point: differentiated(data, point), (z,), (unit,))

        value, gradient = jax.vmap(along, out_axes=(None, 0))(jnp.eye(z.shape[0], dtype=z.dtype))
        if isinstance(direction, SymbolicZero):
            return value, jnp.zeros_like(value)
        return value, product(gradient, direction).astype(value.dtype)

    differentiable.defjvp(rule, symbolic_zeros=True)
    return differentiable
