"""The answer of `recalibrate`."""

import enum
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import AXES, StereoRig, View
from stereorecal.matching import AbstractMatcher
from stereorecal.scoring import Score
from stereorecal.strategies import Status, Trace


class Reason(enum.Enum):
    """Why a candidate was accepted or not; the value is the message."""

    IMPROVED = "the candidate matches more pixels"
    NOT_IMPROVED = "no candidate matches more pixels than the calibration that was given"
    TOO_LITTLE_TEXTURE = "the score is the same everywhere; the images show too little to match"


@dataclass(frozen=True, eq=False)
class Solution:
    """What a recalibration found.

    Attributes:
        rig: the calibration to use: the candidate if accepted, else the one that was given.
        candidate: the best calibration found, accepted or not.
        initial: the calibration that was given.
        accepted, reason: the verdict.
        status, message: how the search ended.
        view, matcher: with which everything was scored; the matcher carries its measured disparity range.
        score_before, score_after: of `initial` and `candidate`, at full scale in `view`.
        trace: the evaluations of the last stage.
        evaluations: number of evaluations over all stages.
        cost: units spent over all stages (one unit: one matcher run on one full-size frame).
        seconds: wall time of the search.
    """

    rig: StereoRig
    candidate: StereoRig
    initial: StereoRig
    accepted: bool
    reason: Reason
    status: Status
    message: str
    view: View
    matcher: AbstractMatcher
    score_before: Score
    score_after: Score
    trace: Trace
    evaluations: int
    cost: float
    seconds: float

    @property
    def change(self) -> Float[np.ndarray, "6"]:
        """Candidate minus given extrinsics: pitch, yaw, roll [rad], x, y, z [m]."""
        return np.asarray(self.candidate.extrinsics) - np.asarray(self.initial.extrinsics)

    def __str__(self) -> str:
        verdict = "accepted" if self.accepted else "rejected, the old calibration stays"
        lines = [
            f"{verdict}: {self.reason.value}",
            f"search   {self.message} ({self.evaluations} evaluations, {self.seconds:.1f} s)",
            f"before   {self.score_before}",
            f"after    {self.score_after}",
        ]
        for axis, before, change in zip(AXES, self.initial.extrinsics, self.change, strict=True):
            factor, unit = (180 / np.pi, "deg") if axis in AXES[:3] else (1e3, "mm")
            lines.append(f"{axis:<8} {factor * before:+10.3f} {unit:<3}  changed by {factor * change:+8.3f}")
        return "\n".join(lines)
