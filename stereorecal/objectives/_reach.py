"""The reach: how far the rig may have drifted, and the box in which the count is searched."""

from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import AXES, StereoRig
from stereorecal.objectives._chart import Chart
from stereorecal.objectives._parameter_names import EXTRINSICS


@dataclass(frozen=True)
class Reach:
    """How far the rig may have drifted: the half widths of the box in which the count is searched. Epipolar stages have
    a prior with a standard deviation of a third of the reach, and may go to twice the reach.

    Attributes:
        degrees: on pitch, yaw and roll.
        baseline_fraction: on y and z, as a fraction of the baseline.

    Raises:
        InputError: if either is not positive, or the rotation exceeds 20 degrees, the translation half the baseline.
    """

    degrees: float = 3.0
    baseline_fraction: float = 0.03

    def __post_init__(self) -> None:
        if not (0 < self.degrees <= 20 and 0 < self.baseline_fraction <= 0.5):
            raise InputError(
                f"a reach of {self.degrees} degrees and {self.baseline_fraction} of the baseline makes no sense; "
                "give up to 20 degrees and up to 0.5."
            )


def as_reach(reach: Any) -> Reach:
    """The given reach, the reach of (degrees, fraction of the baseline), or the default for None.

    Raises:
        InputError: if it is none of these.
    """
    if reach is None or isinstance(reach, Reach):
        return reach or Reach()
    if isinstance(reach, tuple | list) and len(reach) == 2 and all(isinstance(v, Real) for v in reach):
        return Reach(float(reach[0]), float(reach[1]))
    raise InputError(f"reach is {reach!r}; give sr.Reach(degrees=3.0, baseline_fraction=0.03), or a tuple (3.0, 0.03).")


def count_chart(rig: StereoRig, reach: Reach, free: tuple[str, ...] = EXTRINSICS) -> Chart:
    """The box in which counts are searched: as wide as the reach, around the rig's extrinsics."""
    angle, length = np.radians(reach.degrees), reach.baseline_fraction * float(rig.baseline)
    indices = tuple(AXES.index(name) for name in free)
    half_width = np.zeros(6)
    half_width[list(indices)] = [angle if i < 3 else length for i in indices]
    return Chart(np.array(rig.extrinsics, float), half_width, indices)
