"""The health of a calibration as lines of text."""

from collections.abc import Sequence

from stereorecal.geometry import PINHOLE, View
from stereorecal.recalibration._correction import Correction
from stereorecal.recalibration._interval import Interval
from stereorecal.report.number_text import change
from stereorecal.scoring.host import Score


def health_text(
    verdict: str,
    doubts: Sequence[str],
    score: Score,
    view: View | None,
    covered: float,
    row_error: float,
    correction: Correction | None,
) -> str:
    """All that is printed of it; the values are those of `Health`."""
    lines = [verdict, *(f"check      {doubt}" for doubt in doubts), f"matched    {score}"]
    if view is not None and view.projection != PINHOLE:
        lines.append(f"view       {view}")
    if correction is None:
        sure = f"matches that passed all checks cover {100 * covered:.0f} % of the image"
        return "\n".join([*lines, f"row error  not measured: {sure} (chance matches count as matched)"])
    by, rows = correction.axes, correction.rows_px
    angles = ", ".join(f"{name} {_plus_minus(by[name], 3)}" for name in ("pitch", "yaw", "roll"))
    shifts = ", ".join(f"{name} {_plus_minus(by[name], 2)}" for name in ("y", "z"))
    errors = "; ".join(f"{_range(error)} at {distance} B" for distance, error in correction.depth_percent.items())
    return "\n".join(
        [
            *lines,
            f"row error  {row_error:.2f} px; {correction.row_error:.2f} px if corrected",
            f"correction {angles} deg; {shifts} % of the baseline",
            f"systematic {rows.value:.2f} px where the images show something ({rows.low:.2f} to {rows.high:.2f} px)",
            f"depth      {errors}",
        ]
    )


def _plus_minus(found: Interval, digits: int) -> str:
    return f"{found.value:+z.{digits}f} ± {found.high - found.value:.{digits}f}"


def _range(error: Interval) -> str:
    return f"{change(error.value, 'far')} ({change(error.low, 'far')} to {change(error.high, 'far')})"
