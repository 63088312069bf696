"""Dense correspondences from the stereo matcher: pairs of rays of both cameras, with the variance of their row offset;
their row differences under given extrinsics; and tracks, points that a moving rig sees twice.

A grid of cells is laid over each frame; each cell gives the weighted mean of its pixels. The number of correspondences
then depends on the image size only, and pixels whose windows overlap do not count many times.
"""

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal._arrays import AnyArray, Extrinsics, is_host, namespace, product, register_pytree
from stereorecal.geometry import (
    PINHOLE,
    Camera,
    StereoRig,
    cubic_warp,
    projection,
    rectifying_rotations,
    reread,
    rotation_from_euler,
)
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._rectify import (
    Rectified,
    Rotations,
    checked_extrinsics,
    match_frame,
    pure_matcher,
    rectify_frames,
    rotations_by,
)
from stereorecal.scoring._subpixel import WINDOW, refine

_CELLS = 4800  # in a frame: enough to cover it with windows twice over
TILES = (8, 6)  # columns and rows of tiles in a frame, the units of resampling
_FLOOR = 0.01  # pixels: the smallest standard deviation of a window
SMALLEST_SPREAD = 0.05  # pixels; matching is never better than that


@register_pytree
@dataclass(frozen=True, eq=False)
class Correspondences:
    """Pairs of rays, k frames of m cells each.

    Attributes:
        left, right: (k, m, 3) float32, rays in the frames of the left and the right camera: independent of the
            extrinsics under which they were found.
        weight: (k, m) float32, inverse variance of the row offset, 1 in the mean of those found; 0: nothing found.
        tile: (k, m) int32, which tile of which frame a cell lies in.
        focal: of the view, in pixels of the scale at which they were found.
        scale: pixels there per pixel at full size.
        independent: share of them that is independent, since windows overlap.
        projection: of the view, by which rays become rows.
    """

    left: Float[AnyArray, "k m 3"]
    right: Float[AnyArray, "k m 3"]
    weight: Float[AnyArray, "k m"]
    tile: Int[AnyArray, "k m"]
    focal: Float[AnyArray, ""]
    scale: Float[AnyArray, ""]
    independent: Float[AnyArray, ""]
    projection: str = field(default=PINHOLE, metadata={"static": True})

    @property
    def found(self) -> int:
        """How many correspondences there are."""
        return int((np.asarray(self.weight) > 0).sum())

    @property
    def covered(self) -> float:
        """The share of the frame that is covered, of the frame with the most: fog in another frame does not count."""
        return float((np.asarray(self.weight) > 0).mean(axis=1).max())


def with_rays_of(rig: StereoRig, found: Correspondences, *, matched_rig: StereoRig) -> Correspondences:
    """Correspondences with the rays that the cameras of `rig` give to the same pixels.

    Args:
        matched_rig: whose cameras gave the rays of `found`.
    """

    def rays(side: str) -> Float[np.ndarray, "k m 3"]:
        return reread(np.asarray(getattr(found, side)), getattr(matched_rig, side), getattr(rig, side))

    return replace(found, left=rays("left"), right=rays("right"))


def correspondences(
    data: ScoringData, extrinsics: Float[AnyArray, "6"], matcher: AbstractMatcher | str
) -> Correspondences:
    """Dense sub-pixel correspondences of all frames, rectified by `extrinsics` and matched by `matcher`; JAX arrays.
    Arguments and errors are those of `count`.

    Pure, and compiled, as `count`. Composes under `jit` and `vmap` over the extrinsics; its derivatives mean nothing,
    those of `row_differences` do.
    """
    return _correspondences(
        data, checked_extrinsics(extrinsics), pure_matcher(matcher, data.scale, "sr.correspondences")
    )


@partial(jax.jit, static_argnames="matcher")
def _correspondences(data: ScoringData, extrinsics: Extrinsics, matcher: AbstractMatcher) -> Correspondences:
    rotations = rotations_by(extrinsics)
    disparity = rectify_frames(data, rotations, lambda frame: match_frame(matcher, frame))
    return gathered(data, *refined(data, rotations, disparity))


def gathered(
    data: ScoringData, left: Float[AnyArray, "k m 3"], right: Float[AnyArray, "k m 3"], weight: Float[AnyArray, "k m"]
) -> Correspondences:
    """The correspondences from the rays and weights of `refined` for all frames, NumPy or traced."""
    xp, side = namespace(weight), _side(data)
    width, height = data.view.size
    mean = xp.sum(weight) / xp.maximum(xp.sum(weight > 0), 1)
    return Correspondences(
        left,
        right,
        weight / xp.where(mean > 0, mean, 1.0).astype(np.float32),
        xp.asarray(_tiles(len(weight), width // side, height // side)),
        xp.asarray(data.view.focal, np.float32),
        xp.asarray(data.scale, np.float32),
        xp.asarray(_independent(side), np.float32),
        data.view.projection,
    )


def _independent(side: int) -> float:
    """The share of cells that is independent. The noise of a cell is a mean over the pixels that its windows reach,
    each as often as windows reach it, and neighbours share these pixels; exact for white noise and equal weights."""
    reached = np.convolve(np.ones(WINDOW), np.ones(side))
    return float(side * np.sum(reached**2) / np.sum(reached) ** 2) ** 2


def _side(data: ScoringData) -> int:
    """The side of a cell, in pixels."""
    return max(1, round(math.sqrt(data.view.size[0] * data.view.size[1] / _CELLS)))


def refined(data: ScoringData, rotations: Rotations, found: Disparity) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Rays, left and right, and inverse variances of the cells of every frame: (k, m, 3), (k, m, 3), (k, m)."""
    view, side = data.view, _side(data)
    width, height = view.size
    # Not NumPy's: constants of the size of an image would be part of the program, and of the file that keeps it.
    columns, rows = jnp.meshgrid(jnp.arange(width, dtype=jnp.float32), jnp.arange(height, dtype=jnp.float32))

    def rays(x, y, camera):
        return product(view.directions(x, y, camera), rotations[camera])  # turned back by the transpose

    def frame(rectified: Rectified, disparity: Disparity):
        offsets = refine(rectified, disparity)
        weight = jnp.where(offsets.good, 1.0 / (offsets.variance + _FLOOR**2), 0.0)
        fields = jnp.stack([columns, rows, offsets.disparity, offsets.row])
        (x, y, d, v), weight = _means_of_cells(fields, weight, side)
        left, right = rays(x, y, 0), rays(x - d, y + v, 1)
        if view.projection == PINHOLE and not (data.left_camera.lens.WIDE or data.right_camera.lens.WIDE):
            return left, right, weight
        flat = _within_lens_radius(left, data.left_camera) & _within_lens_radius(right, data.right_camera)
        ahead = jnp.asarray([0.0, 0.0, 1.0])  # for what has no ray (x/z, y/z, 1)
        left, right = (jnp.where(flat[:, None], ray, ahead) for ray in (left, right))
        return left, right, jnp.where(flat, weight, 0.0)

    return rectify_frames(data, rotations, frame, warp=cubic_warp, more=(found,))


def _within_lens_radius(rays: Float[jax.Array, "m 3"], camera: Camera) -> Bool[jax.Array, "m"]:
    """Whether rays are those that the estimate works with: (x/z, y/z, 1) within the lens radius."""
    return jnp.hypot(rays[:, 0], rays[:, 1]) < camera.lens_radius * rays[:, 2]


def _means_of_cells(fields: Float[jax.Array, "c h w"], weight: Float[jax.Array, "h w"], side: int):
    """The weighted means of the fields in each cell, (c, m), and the mean weight of its pixels that have one, (m,)."""
    count, height, width = fields.shape
    rows, columns = height // side, width // side

    def totals(values):
        cut = values[..., : rows * side, : columns * side]
        return jnp.sum(cut.reshape(*values.shape[:-2], rows, side, columns, side), axis=(-3, -1))

    total, pixels = totals(weight), totals((weight > 0).astype(jnp.float32))
    means = totals(fields * weight) / jnp.where(total > 0, total, 1.0)
    return means.reshape(count, -1), (total / jnp.maximum(pixels, 1.0)).reshape(-1)


def _tiles(frames: int, columns: int, rows: int) -> Int[np.ndarray, "k m"]:
    """The tile of every cell, numbered over all frames."""
    across = np.arange(columns) * TILES[0] // columns
    down = np.arange(rows) * TILES[1] // rows
    tile = (down[:, None] * TILES[0] + across[None, :]).reshape(-1)
    return (np.arange(frames)[:, None] * TILES[0] * TILES[1] + tile).astype(np.int32)


def row_differences(found: Correspondences, extrinsics: Float[AnyArray, "6"]) -> Float[AnyArray, "k m"]:
    """Row in the rectified left image less the row in the rectified right one, in pixels of the scale of `found`.

    Pure; composes under `jit`, `vmap` over the extrinsics, `grad` and `jacfwd`. Where nothing was found
    (`found.weight` is 0) the value is meaningless.

    Args:
        found: what `correspondences` returned.
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.

    Returns:
        (k, m); NumPy in float64 if both arguments are NumPy's, else JAX in float32.
    """
    extrinsics = checked_extrinsics(extrinsics)
    if is_host(*jax.tree.leaves(found), extrinsics):
        return differences_of(found, extrinsics)
    return _compiled(found, extrinsics)


def differences_of(found: Correspondences, extrinsics: Extrinsics) -> Float[AnyArray, "k m"]:
    """`row_differences` (k, m), for callers that compile it as a part of their own program."""
    xp = namespace(found.left, extrinsics)
    first, second = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])

    def rows(rays, rotation):
        x, y, z = rays[..., 0], rays[..., 1], rays[..., 2]  # written out: a GPU would multiply matrices with ten bits
        (a, b, c), (d, e, f) = rotation[1], rotation[2]
        return row(a * x + b * y + c * z, d * x + e * y + f * z)

    row = projection(found.projection).row
    return xp.asarray(found.focal) * (rows(found.left, first) - rows(found.right, second))


# `checkpoint`: in reverse mode, to keep some seventy small factors of the derivative takes longer than to compute them.
_compiled = jax.jit(jax.checkpoint(differences_of))


def median_row_error(found: Correspondences, extrinsics: Extrinsics) -> float:
    """Median |row difference| in pixels at full size; NaN if nothing was found."""
    valid = np.asarray(found.weight) > 0
    differences = row_differences(found, extrinsics)
    return float(np.median(np.abs(differences[valid])) / float(found.scale)) if valid.any() else float("nan")


@dataclass(frozen=True, eq=False)
class Tracks:
    """m points in two consecutive pairs.

    Attributes:
        left, right: (2, m, 2) pixels (column, row) as the cameras took them, at full size, of the first pair and of the
            second; float64.
        readout: time from the first row of an image to the last, of a rolling shutter, as a share of the time from one
            pair to the other; 0: all rows at once.
    """

    left: Float[np.ndarray, "2 m 2"]
    right: Float[np.ndarray, "2 m 2"]
    readout: float = 0.0

    def __len__(self) -> int:
        return self.left.shape[1]

    def of(self, which: Any) -> "Tracks":
        """The tracks of an index or mask."""
        return replace(self, left=self.left[:, which], right=self.right[:, which])
