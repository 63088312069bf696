"""Reductions over the first axis by halving, which XLA's CPU compiler vectorises, unlike its own reductions there
(half the time of the whole search, measured).

The last two rows of a minimum are left to XLA's own reduction, which it never fuses into what reads it. Otherwise XLA
would recompute the minimum in every step that uses it (a third of the time of the whole search).
"""

import jax
import jax.numpy as jnp
from jaxtyping import Int


def minimum(rows: Int[jax.Array, "d w"]) -> Int[jax.Array, "w"]:
    """Minimum over the rows."""
    while (n := rows.shape[0]) > 2:
        half = (n + 1) // 2
        rows = jnp.minimum(rows[:half], rows[n - half :])
    return jnp.min(rows, axis=0)


def total(rows: Int[jax.Array, "d w"]) -> Int[jax.Array, "w"]:
    """Sum over the rows."""
    while (n := rows.shape[0]) > 1:
        half = n // 2
        pairs = rows[:half] + rows[half : 2 * half]
        rows = jnp.concatenate([pairs, rows[2 * half :]]) if n % 2 else pairs
    return rows[0]
