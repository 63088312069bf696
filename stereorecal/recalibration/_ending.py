"""What the end of a search, or a look at the images, comes to: the same for all ways to judge it."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from stereorecal.decision import Decision, Reason, Seen, reason_of
from stereorecal.estimation import Estimate
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._acceptance import RowErrors, row_errors, verdict_on_count
from stereorecal.recalibration._assessment import Assessment, assessed, without_mismatch
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._freed_intrinsics import Intrinsics, IntrinsicsOutcome, intrinsics_of
from stereorecal.recalibration._mismatch import Mismatch, mismatch_of
from stereorecal.recalibration._regional_misfit import Misfit, misfit
from stereorecal.recalibration._row_residuals import TILES_OF_A_FRAME, RowResiduals, row_residuals
from stereorecal.recalibration._schedule import Schedule
from stereorecal.recalibration._stages import StageRun, last_matched
from stereorecal.recalibration._tile_counts import counts
from stereorecal.recalibration._uncertainty import Uncertainty, uncertainty_of
from stereorecal.scoring import Correspondences
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
        found: matches that it rests on, of the frames that are used; None: those of the last stage.
        row_errors, uncertainty, misfit, intrinsics, estimate, decision, seen, mismatch: as `Findings` has them.
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
    seen: Seen | None = None
    mismatch: Mismatch | None = None
    status: Status = Status.CONVERGED
    message: str = "one look at the images was enough"
    judging_cost: float = 0.0
    found: Correspondences | None = None

    @property
    def without(self) -> tuple[int, ...]:
        """The frames that the candidate does without."""
        return () if self.reason is Reason.FRAMES_DISAGREE else self.excluded


def ending_of_assessment(case: Case, assessment: Assessment) -> Ending:
    """The end that an assessment comes to.

    Args:
        case: with all that may change free.
    """
    assessment = without_mismatch(case, assessment)
    estimated, decision, candidate = assessment.estimate, assessment.decision, assessment.candidate
    rows = rows_at(case, assessment.found, candidate)
    errors = row_errors(rows)
    return Ending(
        candidate=candidate,
        reason=assessment.reason,
        tiles=assessment.tiles,
        excluded=assessment.excluded,
        row_errors=errors,
        uncertainty=uncertainty_of(estimated, candidate, case.without_intrinsics.chart),
        misfit=misfit(rows, late=estimated.is_late),
        intrinsics=_intrinsics(case, assessment, errors) if assessment.reason.accepted else None,
        estimate=estimated,
        decision=decision,
        seen=assessment.seen,
        mismatch=assessment.mismatch,
        judging_cost=assessment.matching_cost,
        found=assessment.found,
    )


def _intrinsics(case: Case, assessment: Assessment, errors: RowErrors) -> Intrinsics | None:
    """What became of intrinsics, or the length of the baseline, that a repair changes; None if it may not."""
    if not case.free.shared:
        return None
    estimated, found, theta = assessment.estimate, assessment.found, assessment.decision.theta
    extrinsics_alone = estimated.chart.rig_at(estimated.with_free(case.free.axes))
    held = row_errors(rows_at(case.of_extrinsics, found, extrinsics_alone))
    return intrinsics_of(
        estimated,
        theta,
        case.free.shared,
        IntrinsicsOutcome.REFINED,
        fixed_px=held.after,
        freed_px=errors.after,
        shown=assessment.seen.places / TILES_OF_A_FRAME,
        expected_px=estimated.row_error_px(theta)[10][0],
    )


def ending_of_search(case: Case, schedule: Schedule, stages: tuple[StageRun, ...]) -> Ending:
    """The end that the stages of a schedule come to, judged by matches, or, where there are none, by the count.

    Args:
        case: with all that may change free.
        stages: that were run: fewer than the schedule has where a budget ended.
    """
    runs = [run for stage in stages for run in stage.runs]
    status, message = (runs[-1].status, runs[-1].message) if runs else (Status.NO_SIGNAL, Status.NO_SIGNAL.value)
    cut = len(stages) < len(schedule.stages) or any(stage.cut for stage in stages)
    if cut:
        status, message = Status.BUDGET, Status.BUDGET.value
    ending = _ended(case, stages, cut=cut, signal=status is not Status.NO_SIGNAL)
    return replace(ending, status=status, message=message)


def _ended(case: Case, stages: tuple[StageRun, ...], *, cut: bool, signal: bool) -> Ending:
    end_rig = stages[-1].ended if stages else case.rig
    run = last_matched(stages)
    assessment = None if cut or run is None else assessed(case, run, end_rig)
    if assessment is not None:
        return ending_of_assessment(case, assessment)
    tiles = counts(case, end_rig)
    if cut or run is not None:  # the count alone hardly sees a wrong yaw
        mismatch = (
            None
            if cut or run is None or run.found is None
            else mismatch_of(case.images, case.matcher, run.found.covered)
        )
        return Ending(end_rig, reason_of(None, Seen(enough=case.images.enough, cut=cut)), tiles, mismatch=mismatch)
    before, after = tiles.sum(axis=(1, 2)).tolist()
    return Ending(end_rig, verdict_on_count(before, after, signal=signal), tiles)


def rows_at(case: Case, found: Correspondences, candidate: StereoRig) -> RowResiduals:
    """Row differences of correspondences, under the initial calibration and a candidate."""
    return row_residuals(case.chart, found, case.chart.coordinates_of(candidate))
