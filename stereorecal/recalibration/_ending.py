"""What the end of a search, or a look at the images, comes to: the same for all ways to judge it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from stereorecal.decision import Decision
from stereorecal.estimation import Estimate
from stereorecal.geometry import StereoRig, same_camera, with_unit_baseline
from stereorecal.recalibration._acceptance import Reason, RowErrors
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._freed_intrinsics import Intrinsics
from stereorecal.recalibration._regional_misfit import Misfit
from stereorecal.recalibration._uncertainty import Uncertainty
from stereorecal.scoring import host
from stereorecal.strategies import Status


@dataclass(frozen=True, eq=False)
class Ending:
    """A judged candidate.

    Attributes:
        candidate: accepted or not.
        reason: the verdict.
        tiles: counts at full scale of all frames, under the initial calibration and the candidate.
        excluded: numbers of the frames that show another rig than the others; all of them count all the same where they
            are too many to say which are wrong.
        status, message: how the search ended, or that none was needed.
        judging_cost: units that went into matches for the verdict alone.
        others: of `Findings`, by its names.
    """

    candidate: StereoRig
    reason: Reason
    tiles: Int[np.ndarray, "2 k tiles"]
    excluded: tuple[int, ...] = ()
    row_errors: RowErrors | None = None
    uncertainty: Uncertainty | None = None
    misfit: Misfit | None = None
    intrinsics: Intrinsics | None = None
    estimate: Estimate | None = None
    decision: Decision | None = None
    status: Status = Status.CONVERGED
    message: str = "one look at the images was enough"
    judging_cost: float = 0.0

    @property
    def without(self) -> tuple[int, ...]:
        """The frames that the candidate does without."""
        return () if self.reason is Reason.FRAMES_DISAGREE else self.excluded


def counts(case: Case, candidate: StereoRig) -> Int[np.ndarray, "2 k tiles"]:
    """Of the tiles of all frames at full scale, under the initial calibration and a candidate."""
    data, rigs = case.images.at(1.0), (case.rig, candidate)
    extrinsics = np.stack([with_unit_baseline(rig.extrinsics) for rig in rigs])
    if same_camera(candidate.left, case.rig.left) and same_camera(candidate.right, case.rig.right):
        return host.counts_by_tile(data, extrinsics, case.matcher)
    through = zip(rigs, extrinsics, strict=True)
    found = [host.counts_by_tile(data.through(rig), of_rig[None], case.matcher) for rig, of_rig in through]
    return np.concatenate(found)
