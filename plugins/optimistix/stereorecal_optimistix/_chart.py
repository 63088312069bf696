"""The way out of the box: optimistix's solvers know no bounds, so they walk where there are none."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

# On the border of the box the chart has no slope, and a solver could never leave it.
_INSIDE = 0.99


class Chart(eqx.Module):
    """z = sin(origin + step · v): from all of R^n into the box [-1, 1]^n, MINUIT's transformation.

    After James & Roos, Computer Physics Communications 10, 1975. A solver starts at v = 0, and its unit of length is
    the first step; float32 is at its finest there.
    """

    origin: Float[np.ndarray | jax.Array, "n"]
    step: Float[np.ndarray | jax.Array, ""]

    def __call__(self, v: Float[jax.Array, "*k n"]) -> Float[jax.Array, "*k n"]:
        """Points of the box, traced; float32, whatever v is."""
        return jnp.sin(self.origin + self.step * v).astype(jnp.float32)

    def on_host(self, v: Float[np.ndarray, "*k n"]) -> Float[np.ndarray, "*k n"]:
        """Points of the box, without a program compiled for every k."""
        return np.sin(np.asarray(self.origin, float) + float(self.step) * v)


def chart_at(start: Float[np.ndarray, "n"], step: float = 1.0) -> Chart:
    """The chart whose origin is `start`, or a little inside of it where `start` is on the border of the box.

    Args:
        step: the unit of length in v, in half widths of the box (in its middle; towards the border it shrinks).
    """
    origin = np.arcsin(np.clip(start, -_INSIDE, _INSIDE))
    return Chart(origin.astype(np.float32), np.asarray(step, np.float32))
