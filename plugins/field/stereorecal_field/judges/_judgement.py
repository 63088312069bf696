"""What a judge says of a rig, and when a rig is worse than another."""

from dataclasses import dataclass

import numpy as np

from stereorecal.comparison import Thresholds

ROWS_WORSE, DEPTH_WORSE = Thresholds.harmful_rows_px, Thresholds.harmful_depth_percent  # px; points at 30 baselines


@dataclass(frozen=True)
class Judgement:
    """The errors of a rig, by what no method looked at; but rows of lidar and of drives in folders are of images that
    methods got, too.

    Attributes:
        row_error_px: |row difference| of the judge's own points: median, of boards root mean square.
        depth_error_percent: at each of DISTANCES, positive: too far; infinite where rays do not meet; None where the
            judge cannot tell depth.
        rotation_error_deg: |error| of pitch, yaw and roll; None where the true rig is not known.
    """

    row_error_px: float
    depth_error_percent: dict[int, float] | None = None
    rotation_error_deg: dict[str, float] | None = None

    def worse_than(self, other: "Judgement") -> bool:
        """Whether rows are worse by more than matters, or |depth error| at 30 baselines is, by a percentage point, or
        either was known of the other and is not any more."""
        mine, before = self.row_error_px, other.row_error_px
        rows = mine > before + ROWS_WORSE or (np.isnan(mine) and not np.isnan(before))
        if self.depth_error_percent is None or other.depth_error_percent is None:
            return bool(rows)
        after, start = (abs(one.depth_error_percent[30]) for one in (self, other) if one.depth_error_percent)
        depth = after > start + DEPTH_WORSE or (np.isnan(after) and not np.isnan(start))
        return bool(rows or depth)
