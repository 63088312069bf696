"""Layers of convolutional networks in JAX, as torch computes them: images are (c, h, w), kernels (out, in, h, w)."""

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

Weights = Mapping[str, Float[np.ndarray, "..."]]
Fields = Float[jax.Array, "_ _ _"]  # channels, rows, columns


def convolved(fields: Fields, weights: Weights, name: str, stride: int = 1) -> Fields:
    """`Conv2d`, padded with zeros so that nothing but the stride makes it smaller."""
    kernel = jnp.asarray(weights[f"{name}.weight"])
    pads = [(size // 2, size // 2) for size in kernel.shape[-2:]]
    exactly = jax.lax.Precision.HIGHEST  # where a GPU would round to 10 bits
    (found,) = jax.lax.conv_general_dilated(fields[None], kernel, (stride, stride), pads, precision=exactly)
    bias = weights.get(f"{name}.bias")
    return found if bias is None else found + jnp.asarray(bias)[:, None, None]


def normalised(fields: Fields, weights: Weights, name: str, epsilon: float) -> Fields:
    """`BatchNorm2d` of a trained network, with or without a scale of its own."""
    mean, variance = weights[f"{name}.running_mean"], weights[f"{name}.running_var"]
    scale = weights.get(f"{name}.weight", np.ones_like(mean)) / np.sqrt(variance + epsilon)
    shift = weights.get(f"{name}.bias", np.zeros_like(mean)) - mean * scale
    return fields * jnp.asarray(scale)[:, None, None] + jnp.asarray(shift)[:, None, None]


def max_pooled(fields: Fields, size: int, stride: int = 1) -> Fields:
    """`MaxPool2d`; with a stride of 1 the size stays."""
    pad = (size // 2, size // 2) if stride == 1 else (0, 0)
    window = (1, size, size), (1, stride, stride), ((0, 0), pad, pad)
    return jax.lax.reduce_window(fields, -jnp.inf, jax.lax.max, *window)


def unit(fields: Fields) -> Fields:
    """Each pixel's vector over the channels, of length 1."""
    return fields / jnp.maximum(jnp.linalg.norm(fields, axis=0), 1e-12)


def in_blocks(fields: Float[jax.Array, "h w"], side: int) -> Fields:
    """The pixels of blocks of `side` by `side` as channels, row by row."""
    height, width = fields.shape
    blocks = fields.reshape(height // side, side, width // side, side)
    return blocks.transpose(1, 3, 0, 2).reshape(side * side, height // side, width // side)


def from_blocks(fields: Fields, side: int) -> Float[jax.Array, "h w"]:
    """The inverse of `in_blocks`."""
    _, rows, columns = fields.shape
    return fields.reshape(side, side, rows, columns).transpose(2, 0, 3, 1).reshape(rows * side, columns * side)
