"""Patch: a flat, textured parallelogram, the primitive of which all solid objects are made.

World frame: x right, y up, z forward, in metres; y = 0 is the water or the road, and the left camera stands
above the origin in the first frame.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Concatenate, ParamSpec, TypeVar

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._noise import Texture, fractal

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
    """A textured parallelogram: the points `origin + a across + b up` with a, b in 0..1.

    Attributes:
        origin, across, up: (3,) [m], world frame.
        levels: `mipmap` of radiance and mask, (h, w, 2) float32; row 0 is b = 1.
        texel: size [m] of a texel of level 0.
    """

    origin: Point
    across: Point
    up: Point
    levels: tuple[Float[np.ndarray, "_ _ 2"], ...]
    texel: float

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
