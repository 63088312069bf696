"""Studio: builds lit patches, walls, slabs, boxes, billboards and poles from paints."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._patch import Light, Paint, Patch, painted

Ground = tuple[float, float] | Float[np.ndarray, "2"]
"""A ground point (x, z) [m]."""


@dataclass(frozen=True, eq=False)
class Studio:
    """What all objects of a scene share.

    Attributes:
        rng: random generator that their makers draw from.
        light: sunlight and skylight.
        eye: height [m] of the left camera.
    """

    rng: np.random.Generator
    light: Light
    eye: float

    def patch(self, origin, across, up, paint: Paint) -> Patch:
        """The parallelogram `origin + a across + b up`, (3,) [m] each, a and b in 0..1, textured by `paint`."""
        return painted(self.rng, self.light, origin, across, up, paint, eye=(0.0, self.eye, 0.0))

    def wall(self, a: Ground, b: Ground, low: float, high: float, paint: Paint, lean: Ground = (0.0, 0.0)) -> Patch:
        """An upright wall over the ground line a-b, from height `low` to `high` [m]; `lean` [m] shifts its top."""
        across = (b[0] - a[0], 0.0, b[1] - a[1])
        return self.patch((a[0], low, a[1]), across, (lean[0], high - low, lean[1]), paint)

    def slab(self, a: Ground, b: Ground, depth: Ground, height: float, paint: Paint) -> Patch:
        """A horizontal surface at `height` [m]: the ground line a-b, swept along `depth` (x, z) [m]."""
        return self.patch((a[0], height, a[1]), (b[0] - a[0], 0.0, b[1] - a[1]), (depth[0], 0.0, depth[1]), paint)

    def box(
        self,
        middle: Ground,
        size: tuple[float, float, float],
        turn: float,
        low: float,
        side: Paint,
        top: Paint,
    ) -> list[Patch]:
        """The visible faces of an upright box.

        Args:
            middle: ground point below its centre.
            size: width, height, depth [m].
            turn: rotation about the vertical [rad].
            low: height of its foot [m].
        """
        width, height, depth = size
        corners = footprint(middle, width, depth, turn)
        patches = []
        for index in range(4):
            a, b = corners[index], corners[(index + 1) % 4]
            outwards = 0.5 * (a + b) - np.array(middle)
            # Back-face culling that keeps what can be seen from within a metre of the ground's origin.
            if outwards @ (0.5 * (a + b)) < 1.0 * np.linalg.norm(outwards):
                patches.append(self.wall(a, b, low, low + height, side))
        if low + height < self.eye + 0.3:
            patches.append(self.slab(corners[0], corners[1], corners[3] - corners[0], low + height, top))
        return patches

    def card(self, middle: Ground, width: float, low: float, high: float, paint: Paint) -> Patch:
        """An upright patch that faces the origin (a billboard)."""
        side = 0.5 * width * np.array([middle[1], -middle[0]]) / np.hypot(middle[0], middle[1])
        return self.wall(np.array(middle) - side, np.array(middle) + side, low, high, paint)

    def pole(self, middle: Ground, width: float, low: float, high: float, albedo: float) -> Patch:
        """A thin round post: a billboard shaded as a cylinder."""

        def paint(canvas):
            across = canvas.x / canvas.width
            round_shade = 0.45 + 0.55 * np.sin(np.pi * np.clip(across * 0.8 + 0.15, 0, 1))
            return albedo * round_shade * (1.0 + 0.15 * canvas.noise(0.3, 0.6))

        return self.card(middle, width, low, high, paint)


def footprint(middle: Ground, width: float, depth: float, turn: float) -> Float[np.ndarray, "4 2"]:
    """Corners (x, z) [m] of a rectangle on the ground, in order, rotated by `turn` [rad]."""
    cos, sin = np.cos(turn), np.sin(turn)
    square = 0.5 * np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]])
    return np.array(middle) + square @ np.array([[cos, sin], [-sin, cos]])
