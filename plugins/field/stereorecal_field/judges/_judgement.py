"""What a judge says of a rig, and when a rig is worse than another."""

from dataclasses import dataclass

from stereorecal.comparison import THRESHOLDS, is_harmful

ROWS_WORSE, DEPTH_WORSE = THRESHOLDS["harmful_rows_px"], THRESHOLDS["harmful_depth_percent"]


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
        rows, depths = (other.row_error_px, self.row_error_px), (other.depth_error_percent, self.depth_error_percent)
        if depths[0] is None or depths[1] is None:
            return is_harmful(rows)
        return is_harmful(rows, (depths[0][30], depths[1][30]))
