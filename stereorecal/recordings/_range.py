"""A distance measured by another sensor: a LIDAR, a beam, a target at a known place, the horizon."""

from dataclasses import dataclass

import numpy as np

from stereorecal._errors import InputError
from stereorecal.recordings._pair import Pair

ALONG = ("ray", "axis")


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
