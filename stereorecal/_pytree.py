"""Frozen dataclasses as pytrees."""

from dataclasses import fields
from typing import Any, TypeVar

import jax

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

    def flatten_with_keys(value: Any):
        children = [(jax.tree_util.GetAttrKey(name), getattr(value, name)) for name in leaves]
        return children, tuple(getattr(value, name) for name in statics)

    def flatten(value: Any):
        return [getattr(value, name) for name in leaves], tuple(getattr(value, name) for name in statics)

    def unflatten(aux: tuple, children: Any) -> T:
        value = object.__new__(cls)
        for name, child in (*zip(leaves, children, strict=True), *zip(statics, aux, strict=True)):
            object.__setattr__(value, name, child)
        for name in aside:
            object.__setattr__(value, name, None)
        return value

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
    return cls
