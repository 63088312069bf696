"""Arrays: their types, NumPy or JAX, dataclasses of them, their derivatives, and values as JSON can hold them."""

import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from types import ModuleType
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Float, Int, UInt8

from stereorecal._errors import InputError

AnyArray = jax.Array | np.ndarray
Vec3 = Float[AnyArray, "3"]
Mat3 = Float[AnyArray, "3 3"]
Extrinsics = Float[AnyArray, "6"]


def namespace(*arrays: Any) -> ModuleType:
    """`jax.numpy` if any argument is a JAX array or tracer, else `numpy`.

    One formula then serves both faces: float64 on the host for calibrations, float32 under a trace.
    """
    return np if is_host(*arrays) else jnp


def product(a: AnyArray, b: AnyArray) -> Any:
    """The matrix product `a @ b`, to float32's precision on every device: left to itself, a GPU may round the factors
    to 10 bits (TF32), which turns the product of two rotations of 20 degrees by up to 0.015 degrees."""
    return a @ b if is_host(a, b) else jnp.matmul(a, b, precision=jax.lax.Precision.HIGHEST)


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


T = TypeVar("T")


def register_pytree(cls: type[T]) -> type[T]:
    """Register a frozen dataclass as a pytree; fields with `metadata={"static": True}` are its structure.

    Fields with `metadata={"aside": True}` are no part of the tree: they are None in what JAX makes of it, so nothing
    compiles again because of them.

    Unlike `jax.tree_util.register_dataclass`, rebuilding does not call `__init__`: JAX rebuilds trees with
    placeholders for leaves, which a validating `__post_init__` would refuse.
    """
    found = fields(cls)  # pyright: ignore[reportArgumentType]
    aside = tuple(f.name for f in found if f.metadata.get("aside"))
    statics = tuple(f.name for f in found if f.metadata.get("static"))
    leaves = tuple(f.name for f in found if f.name not in (*statics, *aside))

    def flatten(value: Any):
        return [getattr(value, name) for name in leaves], tuple(getattr(value, name) for name in statics)

    def flatten_with_keys(value: Any):
        children, aux = flatten(value)
        return list(zip(map(jax.tree_util.GetAttrKey, leaves), children, strict=True)), aux

    def unflatten(aux: tuple, children: Any) -> T:
        value = object.__new__(cls)
        for name, child in (*zip(leaves, children, strict=True), *zip(statics, aux, strict=True)):
            object.__setattr__(value, name, child)
        for name in aside:
            object.__setattr__(value, name, None)
        return value

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
    return cls


def eight_bit(image: Float[AnyArray, "h w"]) -> UInt8[np.ndarray, "h w"]:
    """The image in whole grey levels 0..255, half to even."""
    return np.clip(np.rint(np.asarray(image)), 0, 255).astype(np.uint8)


def central_differences(
    function: Callable[[Float[np.ndarray, "n"]], Float[np.ndarray, "*s"]], at: Float[np.ndarray, "n"], step: float
) -> Float[np.ndarray, "*s n"]:
    """The derivatives of a function of n numbers, to second order in the step."""
    steps = step * np.eye(len(at))
    return np.stack([(function(at + one) - function(at - one)) / (2.0 * step) for one in steps], axis=-1)


def group_medians(
    values: Float[np.ndarray, "m"], number: Int[np.ndarray, "m"], counts: Int[np.ndarray, "g"]
) -> Float[np.ndarray, "g"]:
    """The median of the values of each group, by the number of the group of each value, and how many each group has."""
    ordered, first = values[np.lexsort((values, number))], np.cumsum(counts) - counts
    return 0.5 * (ordered[first + (counts - 1) // 2] + ordered[first + counts // 2])


def json_data(value: Any) -> Any:
    """`value` with lists for tuples and arrays, dictionaries for dataclasses, text for keys, and None for numbers that
    are not finite."""
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: json_data(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, dict):
        return {str(key): json_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_data(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return json_data(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
