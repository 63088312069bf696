"""Is a calibration good as it is? A look at the images through it, without any search."""

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._arrays import refuse_tracers
from stereorecal._plain import plain
from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._acceptance import LEAST_COVERED, ROWS_APART
from stereorecal.recalibration._as_dict import score_as_dict
from stereorecal.recordings import Pairs
from stereorecal.scoring import host, median_row_error, pyramid
from stereorecal.scoring.host import Score, ranged


class Condition(enum.Enum):
    """The verdict on a calibration; the value is the message."""

    HEALTHY = "healthy: the rows are aligned"
    ROWS_APART = "unhealthy: the rows are misaligned; recalibrate"
    TOO_FEW_MATCHES = (
        "unhealthy: too little of the images matches; the rig is far out of calibration, or there is too little texture"
    )


@dataclass(frozen=True)
class Health:
    """How well the images fit together under a calibration.

    Attributes:
        score: the count, in the rig's own view.
        row_error: epipolar (row) error, the median |row difference| of the correspondences, pixels at full size; NaN if
            they cover less than a tenth, since false matches lie on the rows that they were searched on.
        covered: share of the image in which correspondences were found that are good to a fraction of a pixel, of the
            frame that shows most. False matches count as pixels, but hardly here.
    """

    score: Score
    row_error: float
    covered: float

    @property
    def condition(self) -> Condition:
        """Healthy if a tenth of the image is covered and the rows lie within 0.3 pixels. Blind to yaw, nearly: rows
        stay aligned where depth is already wrong."""
        if self.covered < LEAST_COVERED:
            return Condition.TOO_FEW_MATCHES
        return Condition.HEALTHY if self.row_error <= ROWS_APART else Condition.ROWS_APART

    @property
    def healthy(self) -> bool:
        """True if the condition is."""
        return self.condition is Condition.HEALTHY

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables; what is missing is None."""
        return plain(
            {
                **score_as_dict(self.score),
                "row_error_px": self.row_error,
                "covered": self.covered,
                "healthy": self.healthy,
                "condition": self.condition.name.lower(),
                "verdict": self.condition.value,
            }
        )

    def __str__(self) -> str:
        rows = f"{self.row_error:.2f} px (median), measured on {100 * self.covered:.0f} % of the image"
        if np.isnan(self.row_error):
            rows = f"not measured: correspondences cover {100 * self.covered:.0f} % of the image"
        return f"matched    {self.score}\nrow error  {rows}\n{self.condition.value}"


def health(rig: StereoRig, pairs: Pairs, *, matcher: AbstractMatcher | str | None = None) -> Health:
    """Match the pairs under the rig's calibration, at full scale, and measure the epipolar (row) error.

    Args:
        matcher: a matcher, or "sad" (default), "bm" or "sgbm"; without `num_disparities` the range is measured.

    Raises:
        InputError: if images and calibration do not fit.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    images, extrinsics = pyramid(rig, pairs), with_unit_baseline(rig.extrinsics)
    data, matcher = images.at(1.0), ranged(matcher, images)
    found = host.correspondences(data, extrinsics, matcher)
    score = Score(int(host.counts_one_by_one(data, extrinsics[None], matcher)[0]), data.pixels)
    known = found.covered >= LEAST_COVERED
    return Health(score, median_row_error(found, extrinsics) if known else float("nan"), found.covered)
