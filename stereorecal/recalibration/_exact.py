"""The end of a repair whose intrinsics are taken as exact: all that rows show is a drift."""

from stereorecal.geometry import StereoRig
from stereorecal.recalibration._acceptance import Reason, row_errors
from stereorecal.recalibration._agreement import agreed, without
from stereorecal.recalibration._ending import Ending, counts
from stereorecal.recalibration._judging import judged
from stereorecal.recalibration._misfit import systematic
from stereorecal.recalibration._stages import Case
from stereorecal.recalibration._uncertainty import uncertainty
from stereorecal.scoring import Correspondences


def ended_exactly(case: Case, found: Correspondences, near: StereoRig) -> Ending:
    """The candidate of correspondences near a rig, and the verdict on it."""
    frames = agreed(case.chart, found, case.chart.coordinates_of(near), case.images.pairs)
    facts, rows, candidate = frames.facts, row_errors(frames.facts), case.chart.rig_at(frames.facts.z)
    tiles, kept = counts(case, candidate), frames.kept
    covered = without(found, frames.apart).covered
    said, left = judged(facts, case.free.names, len(case.free.axes), tiles[:, kept], rows, covered)
    return Ending(
        candidate,
        Reason.FRAMES_DISAGREE if frames.refused else said.reason,
        tiles,
        frames.apart,
        rows,
        uncertainty(facts.covariance(), systematic(facts, left), case.chart),
        left,
    )
