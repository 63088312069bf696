"""Motion: the pose of the rig in each frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._patch import Point

BOAT_EYE = 2.5
"""Height [m] of the left camera on a boat; chosen."""

VAN_EYE = 2.0
"""Height [m] of the left camera on a van; chosen."""


@dataclass(frozen=True, eq=False)
class RigMotion:
    """How the rig moves through a world.

    Attributes:
        eye: height [m] of the left camera.
        attitude: (pitch, roll) [rad] of the rig at rest; negative pitch looks down.
        sway: amplitude [rad] of the oscillation of pitch and of roll.
        speed: distance [m] travelled per frame at the start.
    """

    eye: float
    attitude: tuple[float, float]
    sway: float
    speed: float

    def pose(self, frame: int) -> tuple[Point, Float[np.ndarray, "3 3"]]:
        """Centre (3,) [m] of the left camera in the world, and the matrix (3, 3) from its frame to the world's.

        The world's y points up and the camera's down, so the matrix is a reflection (determinant -1). The distance
        travelled saturates at 3 m, so that the rig runs into nothing, however many frames are rendered.
        """
        pitch = self.attitude[0] + self.sway * np.sin(1.7 * frame)
        roll = self.attitude[1] + self.sway * np.sin(1.1 * frame)
        (sp, sr), (cp, cr) = np.sin([pitch, roll]), np.cos([pitch, roll])
        tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        centre = np.array([0.1 * np.sin(0.5 * frame), self.eye, 3.0 * np.tanh(self.speed * frame / 3.0)])
        return centre, np.diag([1.0, -1.0, 1.0]) @ tilt


def attitude(rng: np.random.Generator) -> tuple[float, float]:
    """Draw pitch and roll [rad] of a rig at rest; it looks slightly down."""
    return float(rng.uniform(-0.05, 0.0)), float(rng.uniform(-0.03, 0.03))
