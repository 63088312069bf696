"""What those who use a calibration have to expect of it: the epipolar error over the view, and errors of depth."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import central_differences, json_data
from stereorecal._errors import InputError
from stereorecal.estimation import DISTANCES, Estimate, points_shown
from stereorecal.geometry import StereoRig, View
from stereorecal.recalibration._difference import STEP, row_errors_of
from stereorecal.report.number_text import METRES, between, distance

_GRID = (17, 13)  # points of the view
_ROWS_AT = 10.0  # baselines
_SHARES = (0.1, 0.5, 0.9)  # of what the images show: near, in the middle, far
_BASELINES = (5.0, 10.0, 30.0)  # where they show nothing

Distance = tuple[float, str]  # and its unit: mm, cm, m, or B for baselines


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Expected:
    """The errors to expect of a calibration, from the full covariance: what the images say, what they leave to the
    priors of extrinsics and intrinsics, and the misfit.

    Attributes:
        estimated, used, view: the true rig is where the estimate says, and `used` is read in the view.
        rows_px: |epipolar error| where the images show something, as the decision has it; pixels.
    """

    estimated: Estimate
    used: StereoRig
    view: View
    rows_px: float

    @cached_property
    def depth_percent(self) -> Mapping[int, Interval]:
        """The error of depth at 5, 10, 30 and 100 baselines, with its 95 % interval."""
        found = self.estimated.depth_error_percent(self.estimated.chart.coordinates_of(self.used))
        return {int(distance): Interval(*ends) for distance, ends in found.items()}

    @cached_property
    def rows(self) -> Float[np.ndarray, "h w"]:
        """(13, 17) row in the left rectified image less row in the right one, in pixels of the view, of points at 10
        baselines, over the view; NaN where not both cameras see the point."""
        return self._rows_if(self.estimated.theta)

    @cached_property
    def rows_deviation(self) -> Float[np.ndarray, "h w"]:
        """(13, 17) the standard deviation of that."""
        slopes = central_differences(self._rows_if, self.estimated.theta, STEP)
        variance = np.einsum("hwi,ij,hwj->hw", slopes, self.estimated.posterior.covariance, slopes)
        return np.sqrt(np.maximum(variance, 0.0))

    def _rows_if(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "h w"]:
        """The rows, if the rig at θ is the true one."""
        columns, rows = (np.linspace(0, size - 1, n) for size, n in zip(self.view.size, _GRID, strict=True))
        return row_errors_of(self.used, self.estimated.chart.rig_at(theta), self.view, columns, rows, (_ROWS_AT,))[0]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return json_data({"rows_px": self.rows_px, "depth_error_percent": dict(self.depth_percent)})


@dataclass(frozen=True)
class DepthError:
    """The error of depth at a distance, on average over the view.

    Attributes:
        distance: metres.
        percent: of the distance; positive: too far; infinite where a point seems to lie at infinity or beyond.
    """

    distance: float
    percent: Interval

    @property
    def metres(self) -> Interval:
        """The same in metres."""
        return Interval(*(0.01 * self.distance * percent for percent in astuple(self.percent)))

    @property
    def significant(self) -> bool:
        """Whether its interval leaves out 0."""
        return self.percent.low > 0.0 or self.percent.high < 0.0

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return json_data({"percent": self.percent, "metres": self.metres})

    @property
    def where(self) -> str:
        """Its distance, such as "2.5 m"."""
        return distance(self.distance)

    def __str__(self) -> str:
        return between(self.metres.low, self.metres.high)


def reported_depths(
    estimated: Estimate, used: Float[np.ndarray, "n"], distances: Sequence[Distance], best: Float[np.ndarray, "n"]
) -> tuple[DepthError, ...]:
    """The errors of depth of the rig at θ = used.

    Args:
        distances: at which; none: near, middle and far of what the images show, to one digit.
        best: θ of the rig that tells how far away that is: at the posterior's mean depth may be anything.
    """
    baseline = float(estimated.chart.rig.baseline)
    named = dict.fromkeys(value * METRES.get(unit, baseline) for value, unit in distances)  # 2m and 200cm are one
    metres = list(named) or _shown(estimated, best)
    found = estimated.depth_error_percent(used, tuple(one / baseline for one in metres))
    return tuple(DepthError(one, Interval(*ends)) for one, ends in zip(metres, found.values(), strict=True))


def _shown(estimated: Estimate, best: Float[np.ndarray, "n"]) -> list[float]:
    """The distances [m] near, in the middle and far of what the images show, to one digit."""
    chart, shown = estimated.chart, estimated.shown
    depths = [share * float(chart.rig.baseline) for share in _BASELINES]
    if shown is not None:
        points, weights = points_shown(shown, chart, best, estimated.view)
        if len(points):
            order = np.argsort(points[:, 2])
            depths = np.interp(_SHARES, np.cumsum(weights[order]), points[order, 2]).tolist()
    farthest = DISTANCES[-1] * float(chart.rig.baseline)  # beyond, no matcher of a few baselines tells depth
    return sorted({float(f"{min(depth, farthest):.0e}") for depth in depths})


def as_distances(given: str | float | Sequence[str | float] | None) -> tuple[Distance, ...]:
    """Distances from "2m,50cm" or ("2m", 30), where a number alone is in baselines; none for None.

    Raises:
        InputError: if one is no distance.
    """
    if given is None:
        return ()
    parts = given.split(",") if isinstance(given, str) else [given] if isinstance(given, int | float) else given
    return tuple(dict.fromkeys(map(_distance, parts)))


def _distance(part: str | float) -> Distance:
    text = str(part).strip()
    unit = next((unit for unit in (*METRES, "B") if text.endswith(unit)), "")
    try:
        value = float(text.removesuffix(unit))
    except ValueError:
        value = float("nan")
    if not 0.0 < value < float("inf"):
        raise InputError(f"distances: {text!r} is none; give lengths, such as 2m or 50cm, or baselines, such as 30.")
    return value, unit or "B"
