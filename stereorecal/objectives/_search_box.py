"""The search box: which extrinsics are free, how far they may have drifted, and how likely that is."""

from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import AXES, StereoRig
from stereorecal.objectives._chart import Chart

# x stays: the length of the baseline only scales depth (paper, section 3.3).
FREE_AXES = ("pitch", "yaw", "roll", "y", "z")
# The count must be fenced in; the rows know a prior, and a drift just beyond the reach is better found than cut off.
_WIDER = 2.0
_PRIOR = 1.0 / 3.0  # standard deviation of the drift, in reaches: the default reach of 3° and 3 % means 1° and 1 %


@dataclass(frozen=True)
class Reach:
    """How far the rig may have drifted: the half widths of the box in which the count is searched. Epipolar stages,
    which a prior of a third of the reach holds back, may go to twice as far.

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
    """The reach itself, one of (degrees, fraction of the baseline), or the default for None.

    Raises:
        InputError: if it is something else.
    """
    if reach is None or isinstance(reach, Reach):
        return reach or Reach()
    if isinstance(reach, tuple | list) and len(reach) == 2 and all(isinstance(v, Real) for v in reach):
        return Reach(float(reach[0]), float(reach[1]))
    raise InputError(f"reach is {reach!r}; give sr.Reach(degrees=3.0, baseline_fraction=0.03), or a tuple (3.0, 0.03).")


@dataclass(frozen=True, eq=False)
class SearchBox:
    """Where a score is searched.

    Attributes:
        chart: unit box to extrinsics [rad, m]; the initial calibration lies at its centre.
        prior: standard deviation of the drift on each axis, in half widths of the box.
    """

    chart: Chart
    prior: float


def count_box(rig: StereoRig, reach: Reach, free: tuple[str, ...] = FREE_AXES) -> SearchBox:
    """The box in which counts are searched: as wide as the reach, around the rig's extrinsics."""
    return _box(rig, reach, free, 1.0)


def row_box(rig: StereoRig, reach: Reach, free: tuple[str, ...] = FREE_AXES) -> SearchBox:
    """The box of epipolar residuals: twice as wide as the reach, around the rig's extrinsics."""
    return _box(rig, reach, free, _WIDER)


def _box(rig: StereoRig, reach: Reach, free: tuple[str, ...], wider: float) -> SearchBox:
    angle, length = np.radians(reach.degrees), reach.baseline_fraction * float(rig.baseline)
    indices = tuple(AXES.index(name) for name in free)
    half_width = np.zeros(6)
    half_width[list(indices)] = [wider * (angle if i < 3 else length) for i in indices]
    return SearchBox(Chart(np.array(rig.extrinsics, float), half_width, indices), _PRIOR / wider)
