"""How the rig moves through a world: from frame to frame of a scene, and smoothly in time on a drive."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._patch import Point

BOAT_EYE, VAN_EYE = 2.5, 2.0
"""Height [m] of the left camera on a boat and on a van; chosen."""

Pose = tuple[Point, Float[np.ndarray, "3 3"]]
"""Centre (3,) [m] of the left camera in the world, and the matrix (3, 3) from its frame to the world's. The world's y
points up and the camera's down, so the matrix is a reflection (determinant -1)."""

_TURN = np.radians(9.0)  # of a vehicle, to either side


@dataclass(frozen=True, eq=False)
class RigMotion:
    """How the rig moves from frame to frame.

    Attributes:
        eye: height [m] of the left camera.
        attitude: (pitch, roll) [rad] of the rig at rest; negative pitch looks down.
        oscillation: amplitude of pitch and of roll [rad].
        speed: distance [m] travelled per frame at the start.
    """

    eye: float
    attitude: tuple[float, float]
    oscillation: float
    speed: float

    def pose(self, frame: int) -> Pose:
        """The pose in a frame; after 3 m the rig stands, so that it runs into nothing in however many frames."""
        pitch = self.attitude[0] + self.oscillation * np.sin(1.7 * frame)
        roll = self.attitude[1] + self.oscillation * np.sin(1.1 * frame)
        centre = np.array([0.1 * np.sin(0.5 * frame), self.eye, 3.0 * np.tanh(self.speed * frame / 3.0)])
        return centre, _to_world(pitch, 0.0, roll)


def drawn_motion(rng: np.random.Generator, eye: float, oscillation: float, speed: float) -> RigMotion:
    """The motion of a rig that looks slightly down at rest, which is drawn."""
    return RigMotion(eye, (rng.uniform(-0.05, 0.0), rng.uniform(-0.03, 0.03)), oscillation, speed)


@dataclass(frozen=True)
class Course:
    """How a vehicle moves through one place; everything is smooth in time, so that one shutter can be late.

    Attributes:
        eye: height [m] of the left camera.
        speed: metres a frame.
        oscillation: amplitude of pitch and of roll [rad].
        rates: of turning, pitching and rolling, radians of phase a frame.
        phases: likewise.
    """

    eye: float
    speed: float
    oscillation: float
    rates: tuple[float, float, float]
    phases: tuple[float, float, float]

    def pose(self, time: float) -> Pose:
        """At a time in frames since the place was reached."""
        yaw, pitch, roll = (
            size * np.sin(rate * time + phase)
            for size, rate, phase in zip(
                (_TURN, self.oscillation, self.oscillation), self.rates, self.phases, strict=True
            )
        )
        return np.array([0.1 * np.sin(0.05 * time), self.eye, self.speed * time]), _to_world(pitch, yaw, roll)


def drawn_course(rng: np.random.Generator, eye: float, speed: float, oscillation: float) -> Course:
    """A course whose turns and oscillations are drawn."""
    rates = rng.uniform(0.05, 0.12), rng.uniform(0.1, 0.25), rng.uniform(0.1, 0.25)
    return Course(eye, speed, oscillation, rates, tuple(rng.uniform(0.0, 2.0 * np.pi, 3).tolist()))


def _to_world(pitch: float, yaw: float, roll: float) -> Float[np.ndarray, "3 3"]:
    (sp, sr, sy), (cp, cr, cy) = np.sin([pitch, roll, yaw]), np.cos([pitch, roll, yaw])
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return np.diag([1.0, -1.0, 1.0]) @ turn @ tilt
