"""Patch: a flat, textured parallelogram, the primitive of which all solid objects are made; and ray casting onto
patches: depth and radiance of the first one that each ray hits.

World frame: x right, y up, z forward, in metres; y = 0 is the water or the road, and the left camera stands
above the origin in the first frame.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Concatenate, ParamSpec, TypeVar

import cv2
import numpy as np
from jaxtyping import Bool, Float, Shaped

from stereorecal.synthetic._noise import Texture, fractal

_BLOCK = 16  # rays across and down in a block; patches are culled block by block
_NEAR = 0.5  # near plane [m], for culling
_ASIDE = 0.1  # cosine of the angle off the z axis, beyond which no plane of slopes tells what a ray can hit

Point = Float[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class Canvas:
    """The surface that a paint colours: `width` by `height` metres in square texels of `texel` metres, row 0 on top."""

    rng: np.random.Generator
    width: float
    height: float
    texel: float

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return max(2, round(self.height / self.texel)), max(2, round(self.width / self.texel))

    @property
    def x(self) -> Float[np.ndarray, "1 w"]:
        """Distance [m] of the texel centres from the left edge."""
        return ((np.arange(self.shape[1], dtype=np.float32) + 0.5) * (self.width / self.shape[1]))[None, :]

    @property
    def y(self) -> Float[np.ndarray, "h 1"]:
        """Height [m] of the texel centres above the lower edge."""
        rows = self.shape[0]
        return ((rows - 0.5 - np.arange(rows, dtype=np.float32)) * (self.height / rows))[:, None]

    def noise(self, across: float, up: float | None = None, octaves: int = 7, gain: float = 0.65) -> Texture:
        """Fractal noise (h, w) with an rms value of 0.8 to 0.9 whose largest features are `across` by `up` metres."""
        up = across if up is None else up
        return fractal(self.rng, self.shape, (up / self.texel, across / self.texel), octaves, gain)

    def fill(self, image: Texture, x0: float, x1: float, y0: float, y1: float, value: float) -> None:
        """Set the rectangle [x0, x1] by [y0, y1] (metres) of `image` to `value`."""
        rows, columns = self.shape
        top, bottom = (round((1.0 - y / self.height) * rows) for y in (y1, y0))
        left, right = (round(x / self.width * columns) for x in (x0, x1))
        image[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = value


Opaque = Callable[[Canvas], Texture]
"""A paint without holes: returns the albedo (h, w), 0..1."""

Cutout = Callable[[Canvas], tuple[Texture, Texture]]
"""Returns the albedo and an alpha mask (h, w) that is above 0.5 where the surface is opaque."""

Paint = Opaque | Cutout

Settings = ParamSpec("Settings")
Colours = TypeVar("Colours")


def as_paint(
    colour: Callable[Concatenate[Canvas, Settings], Colours],
) -> Callable[Settings, Callable[[Canvas], Colours]]:
    """What makes a paint of settings, from a function that colours a canvas by them."""
    return lambda *values, **named: lambda canvas: colour(canvas, *values, **named)


@dataclass(frozen=True, eq=False)
class Patch:
    """A textured parallelogram: the points `origin + a across + b up` with a, b in 0..1."""

    origin: Point  # [m], world frame
    across: Point  # likewise
    up: Point  # likewise
    levels: tuple[Float[np.ndarray, "_ _ 2"], ...]  # `mipmap` of radiance and mask, (h, w, 2) float32; row 0 is b = 1
    texel: float  # size [m] of a texel of level 0

    @property
    def corners(self) -> Float[np.ndarray, "4 3"]:
        """The corners (4, 3) [m] in order around the patch."""
        sides = np.stack([np.zeros(3), self.across, self.across + self.up, self.up])
        return self.origin + sides

    @cached_property
    def duals(self) -> tuple[Float[np.ndarray, "3 3"], float]:
        """The dual basis of (normal, across, up), in which a point has coordinates (height, a, b); and the area."""
        normal = np.cross(self.across, self.up)
        area = normal @ normal
        return np.stack([normal, np.cross(self.up, normal) / area, np.cross(normal, self.across) / area]), float(area)

    def moved(self, way: Point) -> "Patch":
        """The same patch elsewhere, `way` [m] away."""
        return replace(self, origin=self.origin + way)


def mipmap(texture: Float[np.ndarray, "h w 2"]) -> tuple[Float[np.ndarray, "_ _ 2"], ...]:
    """The texture, and at most six levels of it, each half as fine as the one before."""
    levels = [texture]
    while max(levels[-1].shape[:2]) > 4 and len(levels) < 7:
        rows, columns = levels[-1].shape[:2]
        half = (max(2, (columns + 1) // 2), max(2, (rows + 1) // 2))
        levels.append(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA))
    return tuple(levels)


@dataclass(frozen=True, eq=False)
class Rays:
    """A grid of rays in the world frame."""

    centre: Point  # [m], where all rays start
    directions: Float[np.ndarray, "h w 3"]  # float32, of any length; depth t is at `centre + t direction`
    spread: float  # angle [rad] between neighbouring rays, which selects the mipmap level


def trace(patches: tuple[Patch, ...], rays: Rays) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Depth t (infinite where no patch is hit) and radiance (0 there) where each ray hits first, float32."""
    depth = np.full(rays.directions.shape[:2], np.inf, np.float32)
    radiance = np.zeros_like(depth)
    if not patches:
        return depth, radiance
    lengths = np.linalg.norm(rays.directions, axis=-1)
    corners = np.stack([patch.corners for patch in patches])
    touched = _touched(corners - rays.centre, *_block_bounds(rays.directions, lengths))
    nearest_first = np.argsort(np.linalg.norm(corners.mean(axis=1) - rays.centre, axis=1), kind="stable")
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for index in nearest_first:
            rows, columns = (np.flatnonzero(touched[index].any(axis)) for axis in (1, 0))
            if rows.size:
                window = tuple(slice(_BLOCK * met[0], _BLOCK * (met[-1] + 1)) for met in (rows, columns))
                of_rays = rays.directions[window], lengths[window], depth[window], radiance[window]
                _meet(patches[index], rays.centre, rays.spread, *of_rays)
    return depth, radiance


def _meet(patch: Patch, centre: Point, spread: float, directions, lengths, depth, radiance) -> None:
    """Update `depth` and `radiance` in place where rays hit the patch in front of what they have hit so far."""
    duals, area = patch.duals
    start = duals @ (centre - patch.origin)
    if abs(start[0]) < 1e-9:
        return
    slopes = directions @ duals.T.astype(np.float32)
    t = np.float32(-start[0]) / slopes[..., 0]
    in_front = (t > 0) & (t < depth)
    if not in_front.any():
        return
    a = np.float32(start[1]) + t * slopes[..., 1]
    b = np.float32(start[2]) + t * slopes[..., 2]
    hit = in_front & (a >= 0) & (a < 1) & (b >= 0) & (b < 1)
    rows, columns = (np.flatnonzero(hit.any(axis)) for axis in (1, 0))
    if rows.size == 0:
        return
    box = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    hit, t, slopes = hit[box], t[box], slopes[box]
    t = np.where(hit, t, np.float32(1.0))  # what is not hit is computed, and not used
    # The mipmap is isotropic: a compromise between the short and the long axis of an oblique ray's footprint.
    slant = np.abs(slopes[..., 0]) / np.float32(np.sqrt(area)) / lengths[box]
    footprint = 1.3 * spread * t / np.sqrt(np.maximum(slant, 0.05))
    colour = _sample(patch.levels, a[box], 1.0 - b[box], np.log2(footprint / patch.texel), hit)
    hit = hit & (colour[..., 1] > 0.5)
    depth[box][hit] = t[hit]
    radiance[box][hit] = colour[..., 0][hit]


def _sample(levels, u, v, level, used) -> Float[np.ndarray, "h w c"]:
    """Trilinear lookup in a mipmap at (u, v) in 0..1 and fractional `level`; only the values where `used` count."""
    level = np.clip(np.where(used, level, level[used].mean()), 0.0, len(levels) - 1.0).astype(np.float32)
    total = np.zeros((*level.shape, levels[0].shape[-1]), np.float32)
    for index in range(int(np.floor(level.min())), int(np.ceil(level.max())) + 1):
        rows, columns = levels[index].shape[:2]
        x, y = u * np.float32(columns) - np.float32(0.5), v * np.float32(rows) - np.float32(0.5)
        x, y = (np.minimum(np.maximum(at, np.float32(-1.0)), np.float32(end)) for at, end in ((x, columns), (y, rows)))
        value = cv2.remap(levels[index], x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += np.maximum(0.0, 1.0 - np.abs(level - index))[..., None] * value
    return total


def _block_bounds(
    directions: Float[np.ndarray, "h w 3"], lengths: Float[np.ndarray, "h w"]
) -> Iterator[Shaped[np.ndarray, "2 rows columns"]]:
    """The least, and then the largest, x/z and y/z over the rays of each block of the grid; infinite where one of them
    goes aside or back."""
    aside = directions[..., 2] < _ASIDE * lengths
    slopes = np.moveaxis(directions[..., :2], -1, 0) / np.where(aside, np.float32(1.0), directions[..., 2])
    down, across = (np.arange(0, n, _BLOCK) for n in aside.shape)
    for extreme, end in ((np.minimum, -np.inf), (np.maximum, np.inf)):
        bound = np.where(aside, np.float32(end), slopes)
        yield extreme.reduceat(extreme.reduceat(bound, down, 1), across, 2)


def _touched(
    corners: Float[np.ndarray, "n 4 3"],
    least: Shaped[np.ndarray, "2 rows columns"],
    largest: Shaped[np.ndarray, "2 rows columns"],
) -> Bool[np.ndarray, "n rows columns"]:
    """The blocks with rays that may hit each patch, whose corners are as seen from where the rays start."""
    ahead = corners[..., 2:] >= _NEAR
    slopes = corners[..., :2] / np.where(ahead, corners[..., 2:], 1.0)
    whole = np.all(ahead, axis=1)  # what passes the near plane may be anywhere
    low = np.where(whole, slopes.min(axis=1) - 1e-4, -np.inf)[..., None, None]
    high = np.where(whole, slopes.max(axis=1) + 1e-4, np.inf)[..., None, None]
    met = np.all((least <= high) & (largest >= low), axis=1)
    return (met & np.any(ahead, axis=1)[..., None]) | np.isinf(largest[0])
