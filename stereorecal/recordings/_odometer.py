"""How far the rig had travelled by some time, by something else than its cameras: wheels, GPS, a log of speeds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Real

from stereorecal._errors import InputError


@dataclass(frozen=True, eq=False)
class Odometer:
    """Distances travelled, in the order of time.

    Attributes:
        times: (n,) seconds, of the clock that the pairs' times are of.
        metres: (n,) travelled by then, counted from any moment.
        sigma: standard deviation of all distances alike, as a share: of the size of a wheel, say.
    """

    times: Real[np.ndarray, "n"]
    metres: Real[np.ndarray, "m"]  # as many, or an InputError says otherwise
    sigma: float = 0.01

    def __post_init__(self) -> None:
        times, metres = (np.asarray(some, float) for some in (self.times, self.metres))
        if times.ndim != 1 or times.shape != metres.shape or len(times) < 2:
            raise InputError(
                f"an odometer has times of shape {times.shape} and metres of shape {metres.shape}; give as many of one "
                "as of the other, two at least."
            )
        if not (np.isfinite(times).all() and np.isfinite(metres).all()):
            raise InputError("an odometer's times or metres are not finite; leave out what is not known.")
        if np.any(np.diff(times) <= 0.0):
            at = int(np.argmax(np.diff(times) <= 0.0)) + 1
            raise InputError(f"an odometer's times do not rise, at number {at} ({times[at]:g} s); put them in order.")
        if np.any(np.diff(metres) < 0.0):
            at = int(np.argmax(np.diff(metres) < 0.0)) + 1
            raise InputError(
                f"an odometer goes back at number {at} (to {metres[at]:g} m); give the distance travelled by then, "
                "which never falls."
            )
        if not (np.isfinite(self.sigma) and self.sigma > 0.0):
            raise InputError(f"an odometer's sigma is {self.sigma}; give a positive share, such as 0.01.")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "metres", metres)

    @staticmethod
    def from_speeds(
        times: Sequence[float] | Real[np.ndarray, "n"],
        metres_per_second: Sequence[float] | Real[np.ndarray, "m"],
        sigma: float = 0.01,
    ) -> "Odometer":
        """Of speeds at some times, as wheels and GPS receivers log them; between them they change evenly.

        Raises:
            InputError: as `Odometer`.
        """
        when, speeds = np.asarray(times, float), np.abs(np.asarray(metres_per_second, float))
        if when.shape != speeds.shape or when.ndim != 1 or len(when) < 2:
            raise InputError(f"there are {when.size} times and {speeds.size} speeds; give one for each, two at least.")
        metres = np.concatenate([[0.0], np.cumsum(np.diff(when) * 0.5 * (speeds[1:] + speeds[:-1]))])
        return Odometer(when, metres, sigma)

    @staticmethod
    def from_positions(
        times: Sequence[float] | Real[np.ndarray, "n"], positions: Real[np.ndarray, "m d"], sigma: float = 0.01
    ) -> "Odometer":
        """Of positions in metres at some times, two or three numbers each.

        Raises:
            InputError: as `Odometer`.
        """
        there = np.asarray(positions, float)
        if there.ndim != 2 or len(there) != np.size(times):
            raise InputError(f"there are {np.size(times)} times and positions of shape {there.shape}; give one each.")
        steps = np.linalg.norm(np.diff(there, axis=0), axis=1)
        return Odometer(np.asarray(times, float), np.concatenate([[0.0], np.cumsum(steps)]), sigma)

    def between(self, first: float, second: float) -> float | None:
        """Metres travelled from one time to another; None if it was not running."""
        if not self.times[0] <= first <= second <= self.times[-1]:
            return None
        at, then = np.interp([first, second], self.times, self.metres).tolist()
        return then - at
