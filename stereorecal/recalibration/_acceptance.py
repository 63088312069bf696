"""The verdict in words, and the row errors that go with it."""

import enum
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from stereorecal.geometry import StereoRig
from stereorecal.objectives import Reach, row_chart
from stereorecal.recalibration._row_residuals import RowResiduals

_MOST_LOST = 0.15  # of what the candidate matches; repairs that end well lose 0 to 0.11
FEWEST_PLACES = 6  # of tiles: a covariance of five parameters from fewer says nothing
_EDGE = 0.98  # of the box of the epipolar stages, which is twice the reach
LEAST_COVERED = 0.1  # of the image; good rigs cover a half, rigs half a degree out 0 to 6 %: what false matches cover
FALSE = 0.4  # pixels left by a candidate: chance matches lie evenly within a row of where they were sought, median 0.5


class Reason(enum.Enum):
    """Why a candidate was accepted or not; the value is the message."""

    IMPROVED = "the candidate is a significant improvement"
    MORE_MATCHES = "the candidate matches more pixels"
    RANGES = "the candidate agrees with the ranges, which the initial calibration does not, at no larger epipolar error"
    MOTION = "the rig's own motion shows better depth under the candidate, at no larger epipolar error"
    ALREADY_GOOD = "the initial calibration is already good; there is no significant improvement"
    NOT_IMPROVED = "no candidate matches more pixels than the initial calibration"
    FEWER_MATCHES = (
        "the candidate loses whole regions that match under the initial calibration: something moved between the two "
        "exposures; give other frames"
    )
    TOO_LITTLE_TEXTURE = "too little of the images matches: too little light, texture or grey levels"
    NO_MATCHES = "almost nothing matches, though the images have texture: a drift beyond the reach, or another rig"
    OUT_OF_BUDGET = "the budget ended before the row error of a candidate could be judged; give a larger one"
    MISFIT = (
        "systematic epipolar residuals remain, which no rotation or shift of the cameras explains: the intrinsics "
        "differ, or something moved between the two exposures; four scenes or more would determine the "
        "intrinsics too, best with ranges or frames taken while the rig moves"
    )
    LATE_SHUTTER = (
        "the two images of a pair are not taken at the same time: one shutter is late, as the line on motion says; "
        "trigger both cameras at once, or give frames taken at rest"
    )
    FRAMES_DISAGREE = "the frames show different rigs; take them at rest, or check the synchronisation of the cameras"
    CANNOT_TELL = (
        "no improvement is significant, and the initial calibration may be wrong; other scenes, frames taken while "
        "the rig moves, or ranges would help"
    )
    REACH_EDGE = (
        "the candidate lies at twice the reach: the drift is larger, so give a larger reach, or something moved "
        "between the two exposures"
    )

    @property
    def accepted(self) -> bool:
        """True if the candidate replaces the initial calibration."""
        return self in (Reason.IMPROVED, Reason.MORE_MATCHES, Reason.RANGES, Reason.MOTION)

    @property
    def healthy(self) -> bool:
        """True if the calibration to use is good: repaired, or good from the start."""
        return self.accepted or self is Reason.ALREADY_GOOD


@dataclass(frozen=True, eq=False)
class RowErrors:
    """|Row difference| of the correspondences, pixels at full size: the mean over the tiles of a tile's median.

    Attributes:
        before: under the initial calibration.
        after: under the candidate.
        significance: of the gain, in standard errors over the places of tiles in the frames.
    """

    before: float
    after: float
    significance: float


def row_errors(found: RowResiduals) -> RowErrors:
    """The row errors of what each tile shows, before and after."""
    before, after = found.medians(found.start_residual), found.medians(found.residual)
    gain = found.by_place(before - after)
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
    return RowErrors(float(np.mean(before)), float(np.mean(after)), float(np.mean(gain)) / max(error, 1e-9))


def verdict_on_count(before: int, after: int, *, signal: bool) -> Reason:
    """Where the count is all there is: more is better."""
    if not signal:
        return Reason.TOO_LITTLE_TEXTURE
    return Reason.MORE_MATCHES if after > before else Reason.NOT_IMPROVED


def at_the_edge(z: Float[np.ndarray, "n"]) -> bool:
    """Whether a point lies at the edge of the box of the epipolar stages."""
    return bool(np.any(np.abs(z) > _EDGE))


def drift_within_reach(initial: StereoRig, candidate: StereoRig, reach: Reach) -> Float[np.ndarray, "5"]:
    """Where a candidate lies in the box of the epipolar stages, which ends at 1, twice the reach. The length of the
    baseline is no drift."""
    extrinsics = np.array(candidate.extrinsics, float)
    extrinsics[3:] *= float(initial.baseline) / float(candidate.baseline)
    return row_chart(initial, reach).coordinates(extrinsics)


def is_beyond(z: Float[np.ndarray, "n"]) -> bool:
    """Whether a point lies outside of the box of the epipolar stages: farther than twice the reach."""
    return bool(np.any(np.abs(z) > 1.0))


def loses_regions(tiles: Int[np.ndarray, "2 k tiles"]) -> bool:
    """Whether a candidate loses, in some tiles, what it does not find there: matches under the initial calibration and
    the candidate, of all tiles of all frames. A drift leaves chance matches, which are few; where half of an image has
    moved between the exposures, each half fits a rig of its own."""
    before, after = tiles.astype(float)
    return bool(np.maximum(before - after, 0.0).sum() > _MOST_LOST * after.sum())
