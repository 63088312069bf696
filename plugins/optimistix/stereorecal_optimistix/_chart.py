"""A change of variables that removes the bounds: optimistix's solvers know none."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

# On the border of the box the chart's derivative vanishes, and no solver could leave it. Our choice.
_INSIDE = 0.99


class Chart(eqx.Module):
    """z = sin(origin + step · v): maps R^n into the box [-1, 1]^n, as MINUIT does.

    After James & Roos, Computer Physics Communications 10, 1975. A solver starts at v = 0, where float32 is finest, and
    its unit of length is the first step.
    """

    origin: Float[np.ndarray | jax.Array, "n"]
    step: Float[np.ndarray | jax.Array, ""]

    def __call__(self, v: Float[jax.Array, "*k n"]) -> Float[jax.Array, "*k n"]:
        """Points of the box, traced; float32 whatever the type of v."""
        return jnp.sin(self.origin + self.step * v).astype(jnp.float32)

    def on_host(self, v: Float[np.ndarray, "*k n"]) -> Float[np.ndarray, "*k n"]:
        """Points of the box, on the host: no program is compiled for each k."""
        return np.sin(np.asarray(self.origin, float) + float(self.step) * v)


def chart_at(start: Float[np.ndarray, "n"], step: float = 1.0) -> Chart:
    """The chart with `start` at its origin, moved slightly inwards where `start` is on the border of the box.

    Args:
        step: the unit of length in v, in half widths of the box (at its centre; it shrinks towards the border).
    """
    origin = np.arcsin(np.clip(start, -_INSIDE, _INSIDE))
    return Chart(origin.astype(np.float32), np.asarray(step, np.float32))
