"""Measured epipolar errors compared with the expected ones, which do not include moving objects and misfit."""

import numpy as np
from jaxtyping import Float

from stereorecal.report._regions import GRID, PLACES, significant_errors
from stereorecal.report.repair_report import RepairReport


def larger_than_expected(report: RepairReport) -> list[int]:
    """Places of the view where the measured epipolar error of the calibration to use is significantly larger than the
    expected one."""
    if report.misfit is None or report.expected is None:
        return []
    errors = significant_errors(report.misfit, report.when)
    return sorted(place for place, pixels in errors.items() if pixels > _largest(report.expected, place))


def unmeasured(report: RepairReport) -> list[int]:
    """Places of the view where too little matched in every frame."""
    return [] if report.misfit is None else sorted(set(range(PLACES)) - set(report.misfit["place"]))


def _largest(expected: Float[np.ndarray, "h w"], place: int) -> float:
    """The largest expected error at a place; infinite where there is none."""
    row, column = divmod(place, GRID[0])
    height, width = expected.shape
    rows = slice(row * height // GRID[1], -(-(row + 1) * height // GRID[1]))
    columns = slice(column * width // GRID[0], -(-(column + 1) * width // GRID[0]))
    inside = expected[rows, columns]
    return float(np.nanmax(inside)) if np.isfinite(inside).any() else float("inf")
