"""Studio: where a scene is built, of patches that are lit and of stains on the ground."""

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._ground import Stain
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Canvas, Paint, Patch, as_paint, mipmap
from stereorecal.synthetic._sky import daylight

Ground = tuple[float, float] | Float[np.ndarray, "2"]
"""A ground point (x, z) [m]."""

_PIXEL_ANGLE = 1.0 / 600.0  # [rad], of the default rig (focal length about 600 px); sets the size of texels
_MOST_TEXELS = 450_000  # of a patch; bounds memory and time


class Studio:
    """What all objects of a scene share, and what they leave in it.

    Attributes:
        rng: random generator that objects draw from.
        eye: height [m] of the left camera.
        light: sunlight and skylight.
        patches: of all objects so far.
        stains: where they darken the ground: shadows on a road, reflections in water.
    """

    def __init__(self, rng: np.random.Generator, eye: float) -> None:
        self.rng, self.eye, self.light = rng, eye, daylight(rng)
        self.patches: list[Patch] = []
        self.stains: list[Stain] = []

    def patch(self, origin, across, up, paint: Paint) -> None:
        """Add the parallelogram `origin + a across + b up`, (3,) [m] each, a and b in 0..1, textured by `paint` with
        texels as fine as the left camera can resolve."""
        eye = np.array([0.0, self.eye, 0.0])
        origin, across, up = (np.array(v, float) for v in (origin, across, up))
        width, height = float(np.linalg.norm(across)), float(np.linalg.norm(up))
        grid = np.linspace(0.0, 1.0, 9)
        points = origin + grid[:, None, None] * across + grid[None, :, None] * up
        # A texel covers 0.7 pixels at the nearest point of the patch; what is nearer than 4 m gets no finer ones.
        near = max(4.0, float(np.linalg.norm(points - eye, axis=-1).min()))
        texel = max(0.7 * near * _PIXEL_ANGLE, np.sqrt(width * height / _MOST_TEXELS))
        normal = np.cross(across, up) / (width * height)
        normal = normal * np.sign(normal @ (eye - origin) or 1.0)
        result = paint(Canvas(self.rng, width, height, texel))
        albedo, mask = result if isinstance(result, tuple) else (result, np.ones_like(result))
        radiance = np.clip(albedo, 0.01, 1.0) * np.float32(self.light.on(normal / np.linalg.norm(normal)))
        levels = mipmap(np.stack([radiance, mask], axis=-1).astype(np.float32))
        self.patches.append(Patch(origin, across, up, levels, texel))

    def wall(self, a: Ground, b: Ground, low: float, high: float, paint: Paint, lean: Ground = (0.0, 0.0)) -> None:
        """Add an upright wall over the ground line a-b, from height `low` to `high` [m]; `lean` [m] shifts its top."""
        self.patch((a[0], low, a[1]), (b[0] - a[0], 0.0, b[1] - a[1]), (lean[0], high - low, lean[1]), paint)

    def slab(self, a: Ground, b: Ground, depth: Ground, height: float, paint: Paint) -> None:
        """Add a horizontal surface at `height` [m]: the ground line a-b, swept along `depth` (x, z) [m]."""
        self.patch((a[0], height, a[1]), (b[0] - a[0], 0.0, b[1] - a[1]), (depth[0], 0.0, depth[1]), paint)

    def box(
        self, middle: Ground, size: tuple[float, float, float], turn: float, low: float, side: Paint, top: Paint
    ) -> None:
        """Add the visible faces of an upright box.

        Args:
            middle: ground point below its centre.
            size: width, height, depth [m].
            turn: rotation about the vertical [rad].
            low: height of its foot [m].
        """
        width, height, depth = size
        corners = footprint(middle, width, depth, turn)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            outwards = 0.5 * (a + b) - np.array(middle)
            # Back-face culling that keeps what can be seen from within a metre of the ground's origin.
            if outwards @ (0.5 * (a + b)) < 1.0 * np.linalg.norm(outwards):
                self.wall(a, b, low, low + height, side)
        if low + height < self.eye + 0.3:
            self.slab(corners[0], corners[1], corners[3] - corners[0], low + height, top)

    def card(self, middle: Ground, width: float, low: float, high: float, paint: Paint) -> None:
        """Add an upright patch that faces the origin (a billboard)."""
        side = 0.5 * width * np.array([middle[1], -middle[0]]) / np.hypot(middle[0], middle[1])
        self.wall(np.array(middle) - side, np.array(middle) + side, low, high, paint)

    def pole(self, middle: Ground, width: float, low: float, high: float, albedo: float) -> None:
        """Add a thin round post: a billboard shaded as a cylinder."""
        self.card(middle, width, low, high, _round(albedo))

    def stain(self, outline: Float[np.ndarray, "n 2"], factor: float) -> None:
        """Multiply the light on the ground by `factor` within a convex polygon of ground points."""
        self.stains.append(Stain(outline, factor))

    def mirror(self, a: Ground, b: Ground, height: float, factor: float) -> None:
        """Stain the water with the reflection of a wall of `height` [m] from ground point a to b.

        The reflection fades towards the viewer, since waves blur it: four stains one over another.
        """
        a, b = np.array(a, float), np.array(b, float)
        for part in (0.15, 0.4, 0.7, 1.0):
            near = self.eye / (self.eye + part * height)
            self.stain(np.stack([a, b, b * near, a * near]), factor**0.33)


@as_paint
def _round(canvas: Canvas, albedo: float) -> Texture:
    across = canvas.x / canvas.width
    shade = 0.45 + 0.55 * np.sin(np.pi * np.clip(across * 0.8 + 0.15, 0, 1))
    return albedo * shade * (1.0 + 0.15 * canvas.noise(0.3, 0.6))


def footprint(middle: Ground, width: float, depth: float, turn: float) -> Float[np.ndarray, "4 2"]:
    """Corners (x, z) [m] of a rectangle on the ground, in order, rotated by `turn` [rad]."""
    cos, sin = np.cos(turn), np.sin(turn)
    square = 0.5 * np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]])
    return np.array(middle) + square @ np.array([[cos, sin], [-sin, cos]])
