"""Array types shared by all modules, and the choice between NumPy (host, float64) and JAX (traced, float32)."""

from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Float

from stereorecal._errors import InputError

AnyArray = jax.Array | np.ndarray
Vec3 = Float[AnyArray, "3"]
Mat3 = Float[AnyArray, "3 3"]
Extrinsics = Float[AnyArray, "6"]


def namespace(*arrays: Any) -> ModuleType:
    """`jax.numpy` if any argument is a JAX array or tracer, else `numpy`.

    One formula then serves both faces: float64 on the host for calibrations, float32 under a trace.
    """
    return jnp if any(isinstance(a, jax.Array) for a in arrays) else np


def product(a: AnyArray, b: AnyArray) -> Any:
    """The matrix product `a @ b`, to float32's precision on every device: left to itself, a GPU may round the factors
    to 10 bits (TF32), which turns the product of two rotations of 20 degrees by up to 0.015 degrees."""
    xp = namespace(a, b)
    return a @ b if xp is np else jnp.matmul(a, b, precision=jax.lax.Precision.HIGHEST)


def is_host(*arrays: Any) -> bool:
    """True if no argument is a JAX array or tracer, so values may be read."""
    return not any(isinstance(a, jax.Array) for a in arrays)


def refuse_tracers(name: str, instead: str, *trees: Any) -> None:
    """Keep functions that work on the host out of traces.

    Args:
        name: of the function, as users call it.
        instead: what to use under `jax.jit`, `jax.vmap` and `jax.grad`.

    Raises:
        InputError: if a leaf of the trees is a tracer.
    """
    if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(trees)):
        raise InputError(f"{name} works on the host and cannot be traced by jit, vmap or grad; use {instead}.")
