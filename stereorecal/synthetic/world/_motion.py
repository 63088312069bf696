"""Motion: where the rig is in each frame, and how it is tilted."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._patch import Point

BOAT_EYE = 2.5
"""Height [m] of the left camera on a boat."""

VAN_EYE = 2.0
"""Height [m] of the left camera on a van."""


@dataclass(frozen=True, eq=False)
class Motion:
    """How the rig moves through a world.

    Attributes:
        eye: height [m] of the left camera.
        attitude: (pitch, roll) [rad] of the rig at rest; negative pitch looks down.
        sway: amplitude [rad] of the oscillation of pitch and of roll.
        speed: distance [m] from the first frame to the second.
    """

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


def attitude(rng: np.random.Generator) -> tuple[float, float]:
    """Pitch and roll [rad] of a rig at rest: it looks a little downwards."""
    return float(rng.uniform(-0.05, 0.0)), float(rng.uniform(-0.03, 0.03))
