"""Rows that were measured beside those that are to be expected: the latter know nothing of what moved or was bent."""

import numpy as np
from jaxtyping import Float

from stereorecal.report._regions import GRID, PLACES, sure
from stereorecal.report.repair_report import RepairReport


def larger_than_expected(report: RepairReport) -> list[int]:
    """Places of the view where rows lie surely farther apart, under the calibration to use, than the map of what is to
    be expected says."""
    if report.misfit is None or report.expected is None:
        return []
    apart = sure(report.misfit, report.when)
    return sorted(place for place, pixels in apart.items() if pixels > _largest(report.expected, place))


def unmeasured(report: RepairReport) -> list[int]:
    """Places of the view where too little matched in every frame."""
    return [] if report.misfit is None else sorted(set(range(PLACES)) - set(report.misfit["place"]))


def _largest(expected: Float[np.ndarray, "h w"], place: int) -> float:
    """What is to be expected at a place, at most; infinite where nothing is."""
    row, column = divmod(place, GRID[0])
    height, width = expected.shape
    rows = slice(row * height // GRID[1], -(-(row + 1) * height // GRID[1]))
    columns = slice(column * width // GRID[0], -(-(column + 1) * width // GRID[0]))
    inside = expected[rows, columns]
    return float(np.nanmax(inside)) if np.isfinite(inside).any() else float("inf")
