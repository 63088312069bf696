"""Reverse mode by forward mode, for scores whose reverse pass would keep every matching cost."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

TracedScore = Callable[[Any, jax.Array], jax.Array]


def forward_gradient(score: TracedScore, with_derivatives: TracedScore | None = None) -> TracedScore:
    """The same `score(data, z)`, z (n,), differentiable in reverse with respect to z (data counts as constant).

    The forward pass takes n forward derivatives side by side and keeps only the (n,) gradient: no tape, about n + 1
    times the work of the score.

    Args:
        with_derivatives: what to differentiate instead, if it should differ from what is evaluated.
    """
    differentiated = with_derivatives or score

    @jax.custom_vjp
    def differentiable(data, z):
        return score(data, z)

    def forward(data, z):
        def along(direction):
            return jax.jvp(lambda point: differentiated(data, point), (z,), (direction,))

        return jax.vmap(along, out_axes=(None, 0))(jnp.eye(z.shape[0], dtype=z.dtype))

    def backward(gradient, cotangent):
        return None, cotangent * gradient

    differentiable.defvjp(forward, backward)
    return differentiable
