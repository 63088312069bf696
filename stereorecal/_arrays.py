"""Array types shared by all modules, and the choice between NumPy (host, float64) and JAX (traced, float32)."""

from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

AnyArray = jax.Array | np.ndarray
Vec3 = Float[AnyArray, "3"]
Mat3 = Float[AnyArray, "3 3"]
Extrinsics = Float[AnyArray, "6"]


def namespace(*arrays: Any) -> ModuleType:
    """`jax.numpy` if any argument is a JAX array or tracer, else `numpy`.

    One formula then serves both faces: float64 on the host for calibrations, float32 under a trace.
    """
    return jnp if any(isinstance(a, jax.Array) for a in arrays) else np


def is_host(*arrays: Any) -> bool:
    """True if no argument is a JAX array or tracer, so values may be looked at."""
    return not any(isinstance(a, jax.Array) for a in arrays)
