"""A world: solid patches, what covers the ground, the sky, the haze, and how the rig travels through it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._patch import Patch, Point
from stereorecal.synthetic.surroundings._road import Road
from stereorecal.synthetic.surroundings._sky import Sky
from stereorecal.synthetic.surroundings._water import Water


@dataclass(frozen=True, eq=False)
class World:
    """Everything there is to see.

    Attributes:
        patches: the solid things.
        ground: what covers y = 0.
        sky: the sky.
        haze: distance [m] at which haze hides all but 1/e of the contrast.
        eye: height [m] of the left camera.
        attitude: (pitch, roll) [rad] of the rig at rest; negative pitch looks down.
        sway: how much [rad] pitch and roll change from frame to frame.
        speed: how far [m] the rig moves on from frame to frame.
    """

    patches: tuple[Patch, ...]
    ground: Water | Road
    sky: Sky
    haze: float
    eye: float
    attitude: tuple[float, float]
    sway: float
    speed: float

    def pose(self, frame: int) -> tuple[Point, Float[np.ndarray, "3 3"]]:
        """Where the left camera stands (3,) [m], and the matrix (3, 3) from its frame to the world's.

        The way is bounded (3 m), so that the rig runs into nothing, however many frames are taken.
        """
        pitch = self.attitude[0] + self.sway * np.sin(1.7 * frame)
        roll = self.attitude[1] + self.sway * np.sin(1.1 * frame)
        (sp, sr), (cp, cr) = np.sin([pitch, roll]), np.cos([pitch, roll])
        tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        centre = np.array([0.1 * np.sin(0.5 * frame), self.eye, 3.0 * np.tanh(self.speed * frame / 3.0)])
        return centre, np.diag([1.0, -1.0, 1.0]) @ tilt
