"""What those who use a calibration have to expect of it: the row error over the view, and errors of depth."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import central_differences, json_data
from stereorecal.estimation import Estimate
from stereorecal.geometry import StereoRig, View
from stereorecal.recalibration._rig_errors import STEP, row_errors_of

_GRID = (17, 13)  # points of the view
_ROWS_AT = 10.0  # baselines


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float]:
        """Plain data for JSON."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Expected:
    """Of a calibration, from the full covariance: what the images say, what they leave to the priors of extrinsics and
    intrinsics, and the misfit.

    Attributes:
        rows: (13, 17) row in the left rectified image less row in the right one, in pixels of the view, of points at 10
            baselines, over the view; NaN where not both cameras see the point.
        rows_deviation: (13, 17) the standard deviation of that.
        rows_px: |row error| where the images show something, as the decision has it; pixels.
        depth_percent: error of depth at 5, 10, 30 and 100 baselines, with its 95 % interval.
    """

    rows: Float[np.ndarray, "h w"]
    rows_deviation: Float[np.ndarray, "h w"]
    rows_px: float
    depth_percent: Mapping[int, Interval]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        depth = {distance: error.as_dict() for distance, error in self.depth_percent.items()}
        return json_data({"rows_px": self.rows_px, "depth_error_percent": depth})


def expected_of(estimated: Estimate, used: StereoRig, view: View, rows_px: float) -> Expected:
    """What to expect of a rig, the true one being where the estimate says.

    Args:
        rows_px: of the rig, which the decision tells.
    """
    width, height = view.size
    columns, rows = np.linspace(0, width - 1, _GRID[0]), np.linspace(0, height - 1, _GRID[1])

    def row_errors(theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "h w"]:
        return row_errors_of(used, estimated.chart.rig_at(theta), view, columns, rows, (_ROWS_AT,))[0]

    slopes = central_differences(row_errors, estimated.theta, STEP)
    variance = np.einsum("hwi,ij,hwj->hw", slopes, estimated.posterior.covariance, slopes)
    found = estimated.depth_error_percent(estimated.chart.coordinates_of(used))
    depth = {int(distance): Interval(*ends) for distance, ends in found.items()}
    return Expected(row_errors(estimated.theta), np.sqrt(np.maximum(variance, 0.0)), rows_px, depth)
