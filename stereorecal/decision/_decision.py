"""What is decided of a calibration."""

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._json_data import json_data
from stereorecal.decision._tolerances import DEFAULT, Tolerances


class Verdict(enum.Enum):
    """What to do with a calibration."""

    REPAIR = "another calibration is a significant improvement"
    GOOD = "the rows are aligned, and there is no significant improvement"
    CANNOT_TELL = "the rows may be misaligned, and there is no significant improvement"


@dataclass(frozen=True, eq=False)
class Decision:
    """What to do with the calibration that an estimate started from.

    Attributes:
        verdict: what to do.
        theta: (n,) the candidate: that of least loss of those that may replace the calibration; if none may, of all.
        keeps_depth: whether the candidate was chosen to read depth as the calibration does.
        worse: probability that the candidate is worse than the calibration, in rows or in depth.
        better: probability that its rows are better by what a matcher notices.
        loss: that is to be expected of the candidate: rows over what a matcher notices, and depth over a point.
        rows_px: (2, 3) row error over the view, of the calibration and of the candidate: median, 95 % interval.
        ranges_agree: whether ranges agree with the candidate, and not with the calibration.
        tolerances: by which it was decided.
        by_rows: whether its rows are better for sure, also those that most frames show.
        judged_at: the distances at which rows were judged, baselines; depth at the farthest.
        left_to_intrinsics: whether the rows that the candidate leaves are explained by intrinsics that stay.
    """

    verdict: Verdict
    theta: Float[np.ndarray, "n"]
    keeps_depth: bool
    worse: float
    better: float
    loss: float
    rows_px: Float[np.ndarray, "2 3"]
    ranges_agree: bool = False
    tolerances: Tolerances = DEFAULT
    by_rows: bool = False
    judged_at: tuple[float, ...] = DEFAULT.distances
    left_to_intrinsics: bool = False

    @property
    def refused(self) -> bool:
        """Whether the calibration stays."""
        return self.verdict is not Verdict.REPAIR

    @property
    def by_ranges(self) -> bool:
        """Whether ranges alone ask for the candidate: its rows are not better for sure."""
        return not self.refused and not self.by_rows and self.ranges_agree

    @property
    def by_motion(self) -> bool:
        """Whether it is the rig's own motion that asks for the candidate: its depth is better for sure. A repair that
        neither rows nor ranges ask for leaves only motion."""
        return not self.refused and not self.by_rows and not self.ranges_agree

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        before, after = ({"value": m, "low": low, "high": high} for m, low, high in self.rows_px.tolist())
        return json_data(
            {
                "verdict": self.verdict.name.lower(),
                "keeps_depth": self.keeps_depth,
                "probability_better": self.better,
                "probability_worse": self.worse,
                "rows_px": {"before": before, "candidate": after},
                "distances": self.judged_at,
            }
        )

    @property
    def explains(self) -> bool:
        """Whether the rig explains the rows: the candidate's are those of a good calibration, as likely as not."""
        return bool(self.rows_px[1, 0] <= self.tolerances.good_rows_px)

    @property
    def is_understood(self) -> bool:
        """Whether the candidate explains the rows, or intrinsics explain what it leaves."""
        return self.explains or self.left_to_intrinsics

    @property
    def corrects_most(self) -> bool:
        """Whether the candidate corrects more of the rows than it leaves, as likely as not."""
        before, after = self.rows_px[:, 0]
        return bool(after < before - after)
