"""What a trial did to rows and depth, by the true rig, and whether that is harm."""

from typing import Any

import numpy as np

from stereorecal.geometry import StereoRig, View
from stereorecal.recalibration import difference

DISTANCES = (10, 30)  # baselines, at which depth is compared


def errors_by_truth(start: StereoRig, final: StereoRig, truth: StereoRig, view: View) -> dict[str, Any]:
    """Of both rigs, under "start" and "final": "row_error_px", median |row difference| over the view of points at 10
    baselines and at infinity (NaN where nothing is seen), and "depth_error_percent" by distance in baselines (positive:
    too far; infinite where rays do not meet)."""
    wrong = {name: difference(rig, truth, view=view) for name, rig in (("start", start), ("final", final))}
    return {
        "row_error_px": {name: one.row_error_median for name, one in wrong.items()},
        "depth_error_percent": {
            name: {str(distance): one.depth_error_percent[distance] for distance in DISTANCES}
            for name, one in wrong.items()
        },
    }


def is_harmful(errors: dict[str, Any], rows_px: float, depth_percent: float) -> bool:
    """Whether rows are worse than at the start by more than `rows_px`, or |depth error| at 30 baselines has grown by
    more than `depth_percent` points, or either was known before and is not any more."""
    rows, depth = errors["row_error_px"], errors["depth_error_percent"]
    before, after = (abs(depth[when]["30"]) for when in ("start", "final"))
    worse_rows = rows["final"] > rows["start"] + rows_px or (np.isnan(rows["final"]) and not np.isnan(rows["start"]))
    worse_depth = after > before + depth_percent or (np.isnan(after) and not np.isnan(before))
    return bool(worse_rows or worse_depth)
