"""Distances measured by something else than the cameras: of what a pixel shows, by a LIDAR, a beam, a target at a known
place, the horizon; and travelled by the rig, by wheels, GPS, a log of speeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Real

from stereorecal._errors import InputError
from stereorecal.recordings._pair import Pair

ALONG = ("ray", "axis")

LONGEST_GAP = 1.1  # seconds between samples: a log of one a second, whose clock jitters, has no gaps
_NOISE = 0.05  # metres


@dataclass(frozen=True, eq=False)
class Range:
    """A distance that was measured of what one pixel of a left image shows.

    Attributes:
        pair: the pair, its name ("recording/name" where several recordings have one of that name), or its number among
            the pairs of the only recording.
        left_pixel: (column, row) in the left image as it was taken.
        metres: from the centre of the left camera; `inf` for the horizon or a star.
        sigma: standard deviation, metres; default 1 % of the distance.
        along: what `metres` are measured along: the "ray" to the pixel, as a laser does, or the optical "axis" of the
            left camera as it was taken, as the depth of a point cloud or of a depth image.
    """

    pair: Pair | str | int
    left_pixel: tuple[float, float]
    metres: float
    sigma: float | None = None
    along: str = "ray"

    def __post_init__(self) -> None:
        if not self.metres > 0.0:
            raise InputError(f"a range of {self.metres} m makes no sense; give metres, or inf for the horizon.")
        if self.sigma is not None and not (np.isfinite(self.sigma) and self.sigma > 0.0):
            raise InputError(f"a range's standard deviation is {self.sigma} m; give a positive one, or None for 1 %.")
        if self.along not in ALONG:
            raise InputError(f'a range is measured along the "ray" or along the optical "axis", not {self.along!r}.')
        if len(self.left_pixel) != 2 or not np.isfinite(self.left_pixel).all():
            raise InputError(f"left_pixel is {self.left_pixel}; give (column, row) in the left image.")


@dataclass(frozen=True, eq=False)
class Odometer:
    """Distances travelled, in the order of time. Of a way through a gap, samples that are more than 1.1 s apart, it
    says nothing.

    Attributes:
        times: (n,) seconds, of the clock that the pairs' times are of.
        metres: (n,) travelled by then, counted from any moment.
        sigma: standard deviation of all distances alike, as a share: of the size of a wheel, say.
        positions: (n, d) where it was then, metres; a way is then the straight line from one to the other, as `metres`,
            the sum of all steps, grows by the noise of each. None: not known.
        noise: standard deviation of each number of each position by itself, metres.
    """

    times: Real[np.ndarray, "n"]
    metres: Real[np.ndarray, "m"]  # as many, or an InputError says otherwise
    sigma: float = 0.01
    positions: Real[np.ndarray, "k d"] | None = None  # as many
    noise: float = 0.0

    def __post_init__(self) -> None:
        times, metres = (np.asarray(some, float) for some in (self.times, self.metres))
        if self.positions is not None:
            places = np.asarray(self.positions, float)
            if places.ndim != 2 or len(places) != times.size:
                raise InputError(f"there are {times.size} times and positions of shape {places.shape}; give one each.")
            if not np.isfinite(places).all():
                raise InputError("an odometer's positions are not finite; leave out what is not known.")
            object.__setattr__(self, "positions", places)
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
        if not (np.isfinite(self.noise) and self.noise >= 0.0):
            raise InputError(f"an odometer's noise is {self.noise}; give metres, 0 or more, such as {_NOISE}.")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "metres", metres)

    @staticmethod
    def from_speeds(
        times: Sequence[float] | Real[np.ndarray, "n"],
        metres_per_second: Sequence[float] | Real[np.ndarray, "m"],
        sigma: float = 0.01,
    ) -> "Odometer":
        """An odometer from speeds at some times, as wheels and GPS receivers log them; between them they change evenly.

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
        times: Sequence[float] | Real[np.ndarray, "n"],
        positions: Real[np.ndarray, "m d"],
        sigma: float = 0.01,
        noise: float = _NOISE,
    ) -> "Odometer":
        """An odometer from positions at some times, two or three numbers each, metres; straight lines in between.

        Args:
            noise: standard deviation of each number of each position by itself, metres.

        Raises:
            InputError: as `Odometer`.
        """
        places = np.asarray(positions, float)
        steps = np.linalg.norm(np.diff(np.atleast_2d(places), axis=0), axis=1)
        metres = np.append(0.0, np.cumsum(steps))
        return Odometer(np.asarray(times, float), metres, sigma, places, noise)

    def between(self, first: float, second: float) -> float | None:
        """Metres travelled from one time to another; None if it was not running, or has a gap there."""
        if not self.times[0] <= first <= second <= self.times[-1]:
            return None
        before = max(int(np.searchsorted(self.times, first, "right")) - 1, 0)
        after = int(np.searchsorted(self.times, second, "left"))
        if np.any(np.diff(self.times[before : after + 1]) > LONGEST_GAP):
            return None
        if self.positions is not None:
            ends = [np.interp([first, second], self.times, axis) for axis in self.positions.T]
            return float(np.linalg.norm(np.diff(ends, axis=1)))
        at, then = np.interp([first, second], self.times, self.metres).tolist()
        return then - at

    def deviation(self, metres: float, together: int = 1) -> float:
        """The standard deviation of such a way, metres; larger where so many ways, which err alike in part, are taken
        as independent."""
        return float(np.hypot(self.sigma * np.sqrt(together) * metres, np.sqrt(2.0) * self.noise))
