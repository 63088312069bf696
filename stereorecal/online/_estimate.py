"""A recursive estimate of where the true rig stands, and by how much a shutter is late.

A Kalman filter in its information form (Anderson & Moore 1979, chapter 6), over six numbers: the offset of the true rig
from the one that was given first (pitch, yaw, roll in degrees, y, z in percent of the baseline), and the delay of the
right shutter in frames. What one look measures is the offset plus the delay times the rig's own turn between frames.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

SIZE = 5
POSES = 3  # ways in which a late shutter poses as an offset
_DELAY = 0.5  # frames: standard deviation before anything is known
_LATE = 0.3  # frames: a delay that is thought possible before one is named
_TRAVEL = 3.0  # percent of the baseline: by what the rig may travel during a delay
_DELAY_WANDER = 5e-3  # a frame, likewise


@dataclass(frozen=True, eq=False)
class Measurement:
    """What one look says of the offset, in directions that do not depend on each other.

    Attributes:
        frame: number of the pair.
        offset: (5,) measured.
        information: (5, 5) inverse covariance; singular where the look says nothing.
        turn: (5,) by which a delay of one frame would move it.
    """

    frame: int
    offset: Float[np.ndarray, "5"]
    information: Float[np.ndarray, "5 5"]
    turn: Float[np.ndarray, "5"]

    @property
    def design(self) -> Float[np.ndarray, "5 6"]:
        """What is measured of an estimate."""
        return np.column_stack([np.eye(SIZE), self.turn])

    @property
    def poses(self) -> Float[np.ndarray, "5 3"]:
        """What a late shutter would add, a standard deviation each: of the rig's turn, of its travel along y and z."""
        return np.column_stack([_LATE * self.turn, _TRAVEL * np.eye(SIZE)[:, 3:]])

    def weighed(self, share: float) -> "Measurement":
        """The same with a share of its information."""
        return replace(self, information=share * self.information)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Mean (6,) and covariance (6, 6): the offset, and the delay."""

    mean: Float[np.ndarray, "6"]
    covariance: Float[np.ndarray, "6 6"]

    @property
    def offset(self) -> Float[np.ndarray, "5"]:
        """Of the true rig, degrees and percent."""
        return self.mean[:SIZE]

    @property
    def of_offset(self) -> Float[np.ndarray, "5 5"]:
        """The covariance of the offset."""
        return self.covariance[:SIZE, :SIZE]

    def later(self, wander: tuple[float, float, float], shift: float) -> "Estimate":
        """A frame later: a random walk."""
        steps = np.array([*wander, shift, shift, _DELAY_WANDER]) ** 2
        covariance = self.covariance + np.diag(steps)
        covariance[SIZE, SIZE] = min(covariance[SIZE, SIZE], _DELAY**2)
        return replace(self, covariance=covariance)

    def seen(self, measured: Measurement) -> "Estimate":
        """With one more measurement."""
        design = measured.design
        pull = design.T @ measured.information @ (measured.offset - design @ self.mean)
        known = np.linalg.inv(self.covariance) + design.T @ measured.information @ design
        covariance = np.linalg.inv(known)
        return Estimate(self.mean + covariance @ pull, 0.5 * (covariance + covariance.T))

    def chance_of(self, measured: Measurement) -> float:
        """Of a measurement as far from the estimate as this one, or farther (chi-square of the innovation)."""
        from scipy.special import chdtrc  # a third of a second to import

        values, axes = np.linalg.eigh(measured.information)
        kept = values > 1e-9 * max(float(values[-1]), 1e-12)
        if not kept.any():
            return 1.0
        design = axes[:, kept].T @ measured.design
        innovation = axes[:, kept].T @ measured.offset - design @ self.mean
        spread = design @ self.covariance @ design.T + np.diag(1.0 / values[kept])
        return float(chdtrc(int(kept.sum()), float(innovation @ np.linalg.solve(spread, innovation))))

    def late(self) -> "Estimate":
        """After a shutter may have begun to be late, or ceased: the rig turns and travels while it is."""
        steps = np.array([0.0, 0.0, 0.0, _TRAVEL, _TRAVEL, _DELAY]) ** 2
        return replace(self, covariance=self.covariance + np.diag(steps))

    def shaken(self, prior: Float[np.ndarray, "5"]) -> "Estimate":
        """After a knock: as far away as the prior says."""
        return replace(self, covariance=self.covariance + np.diag(np.append(prior, 0.0) ** 2))


def at_start(prior: Float[np.ndarray, "5"]) -> Estimate:
    """The rig that was given, and how far it may be off (standard deviations)."""
    return Estimate(np.zeros(SIZE + 1), np.diag(np.append(prior, _DELAY) ** 2))
