"""The course of a vehicle through a place: its pose at any time, so that one shutter can be late."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._patch import Point

_SPEED = {"harbour": 0.05, "coast": 0.05, "open-sea": 0.1, "street": 0.12}  # metres a frame
_TURN = np.radians(9.0)  # to either side
_SWAY = {"street": 0.004}  # of pitch and roll [rad]
_SWAY_AFLOAT = 0.012


@dataclass(frozen=True)
class Course:
    """How the rig moves through one place; everything is smooth in time.

    Attributes:
        eye: height [m] of the left camera.
        speed: metres a frame.
        sway: amplitude of pitch and of roll [rad].
        rates: of turning, pitching and rolling, radians of phase a frame.
        phases: likewise.
    """

    eye: float
    speed: float
    sway: float
    rates: tuple[float, float, float]
    phases: tuple[float, float, float]

    def pose(self, time: float) -> tuple[Point, Float[np.ndarray, "3 3"]]:
        """As `RigMotion.pose`, at a time in frames since the place was reached."""
        yaw, pitch, roll = (
            size * np.sin(rate * time + phase)
            for size, rate, phase in zip((_TURN, self.sway, self.sway), self.rates, self.phases, strict=True)
        )
        (sp, sr, sy), (cp, cr, cy) = np.sin([pitch, roll, yaw]), np.cos([pitch, roll, yaw])
        turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        centre = np.array([0.1 * np.sin(0.05 * time), self.eye, self.speed * time])
        return centre, np.diag([1.0, -1.0, 1.0]) @ turn @ tilt


def make_course(kind: str, eye: float, rng: np.random.Generator) -> Course:
    """Draw a course through a place of a kind."""
    rates = (float(rng.uniform(0.05, 0.12)), float(rng.uniform(0.1, 0.25)), float(rng.uniform(0.1, 0.25)))
    phases = tuple(rng.uniform(0.0, 2.0 * np.pi, 3).tolist())
    return Course(eye, _SPEED[kind], _SWAY.get(kind, _SWAY_AFLOAT), rates, phases)
