"""The end of a repair by the estimate: the candidate that loses least in rows and depth, and the one decision."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import Decision, Verdict, decide
from stereorecal.estimation import Estimate, estimate, rig_parameters
from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameters
from stereorecal.recalibration._acceptance import (
    FEWEST_PLACES,
    LEAST_COVERED,
    Reason,
    RowErrors,
    at_the_edge,
    drift_within_reach,
    is_beyond,
    loses_regions,
    row_errors,
)
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._default_free import free_and_decision
from stereorecal.recalibration._ending import Ending, counts
from stereorecal.recalibration._freed_intrinsics import Intrinsics, IntrinsicsOutcome, intrinsics_of
from stereorecal.recalibration._motion_windows import windows_of, without_frames
from stereorecal.recalibration._ranges_of_case import matched_ranges
from stereorecal.recalibration._regional_misfit import misfit
from stereorecal.recalibration._row_residuals import TILES_OF_A_FRAME, RowResiduals, row_residuals
from stereorecal.recalibration._stages import FEWEST, StageRun, matched
from stereorecal.recalibration._uncertainty import uncertainty_of
from stereorecal.recalibration._unmatched import LIKELY, MOST_EXCLUDED, is_sparse, unmatched, without_frames_of
from stereorecal.scoring import Correspondences, image_quality, is_coarse
from stereorecal.scoring.host import refuse_swapped_images


@dataclass(frozen=True, eq=False)
class Answer:
    """What the correspondences of all frames say together, and what follows.

    Attributes:
        found: of the frames that are kept.
        estimate: of the rig that they show.
        excluded: numbers of the frames that show another rig.
        frames_disagree: they are too many to say which are wrong; all count then.
        free: what may change, if frames bear out that more must than the case has free.
        decision: on the initial calibration.
        sparse: they cover little of what has texture: no reason to call a calibration good.
        coarse: the images have too few grey levels.
    """

    found: Correspondences
    estimate: Estimate
    excluded: tuple[int, ...]
    frames_disagree: bool
    free: Parameters
    decision: Decision
    sparse: bool
    coarse: bool

    @property
    def enough(self) -> bool:
        """Whether enough of the images matches for a verdict: chance matches cover little, and few places; and images
        of few grey levels match elsewhere than their scene does."""
        seen = self.found.covered >= LEAST_COVERED and len(_occupied_tiles(self.found)) >= FEWEST_PLACES
        return seen and not self.coarse


def estimate_and_decide(case: Case, run: StageRun, end_rig: StereoRig, *, corners: bool) -> Answer:
    """The answer of a stage's correspondences.

    Args:
        run: that found them.
        end_rig: where the search ended, with the cameras of the case's rig.
        corners: whether images are matched once more, through the rig that was found, where intrinsics may change:
            towards the corners, windows meet other things under other lenses.
    """
    found = run.found
    assert found is not None
    excluded_frames, frames_disagree, estimated = _without_other_rigs(case, found, end_rig)
    used_matches = found if frames_disagree else without_frames_of(found, excluded_frames)
    if corners and case.free.intrinsics:
        estimated, used_matches = _rematched(case, estimated, used_matches, run)
    free, decision = free_and_decision(case, used_matches, estimated)
    if corners and free.intrinsics and not case.free.intrinsics:
        estimated, used_matches = _rematched(case, estimated, used_matches, run)
        decision = decide(estimated, free.names, case.tolerances, proven=True)
    sparse = used_matches.covered < LIKELY and is_sparse(
        used_matches.covered, max(image_quality(pair).texture for pair in case.images.pairs)
    )
    return Answer(
        found=used_matches,
        estimate=estimated,
        excluded=tuple(sorted(excluded_frames)),
        frames_disagree=frames_disagree,
        free=free,
        decision=decision,
        sparse=sparse,
        coarse=all(is_coarse(pair) for pair in case.images.pairs),
    )


def _without_other_rigs(
    case: Case, found: Correspondences, end_rig: StereoRig
) -> tuple[tuple[int, ...], bool, Estimate]:
    """The estimate without the frames that show another rig, one more excluded at a time: their numbers, whether they
    are too many to say which are wrong, and the estimate, of all frames in that case."""
    excluded_frames = unmatched(found, case.images.pairs) if len(found.weight) > 1 else ()
    seeing = int(np.any(np.asarray(without_frames_of(found, excluded_frames).weight) > 0, axis=1).sum())
    most = MOST_EXCLUDED * (seeing + len(excluded_frames))
    start, tracks = rig_parameters(case.rig).coordinates_of(end_rig), windows_of(case, found)

    def estimate_without(frames: tuple[int, ...], start: Float[np.ndarray, "n"]) -> Estimate:
        return estimate(
            without_frames_of(found, frames),
            case.rig,
            case.prior,
            start=start,
            ranges=matched_ranges(case, found, end_rig, frames),
            windows=without_frames(case, tracks, frames),
            view=case.images.view,
        )

    while True:
        estimated = estimate_without(excluded_frames, start)
        frames_disagree = len(excluded_frames) > most
        if frames_disagree or not estimated.other_rigs:
            break
        excluded_frames, start = (*excluded_frames, estimated.other_rigs[0].frame), estimated.theta
    return excluded_frames, frames_disagree, estimate_without((), start) if frames_disagree else estimated


def _rematched(
    case: Case, estimated: Estimate, found: Correspondences, run: StageRun
) -> tuple[Estimate, Correspondences]:
    """The estimate by correspondences that are found once more, under the rig that was estimated, and these."""
    rematched = matched(case.images.at(run.scale, run.stage.frames), estimated.chart, estimated.theta, case.matcher)
    used_frames = np.any(np.asarray(found.weight) > 0, axis=1)
    rematched = replace(rematched, weight=np.asarray(rematched.weight) * used_frames[:, None])
    if rematched.found < FEWEST:
        return estimated, found
    estimated = estimate(
        rematched,
        case.rig,
        case.prior,
        start=estimated.theta,
        ranges=estimated.matched_ranges,
        windows=estimated.windows,
        view=estimated.view,
    )
    return estimated, rematched


def ended_by(case: Case, answer: Answer) -> Ending:
    """The candidate of an answer, and the verdict on it."""
    estimated, decision, found = answer.estimate, answer.decision, answer.found
    judged = case.with_free(answer.free)
    candidate = estimated.chart.rig_at(decision.theta)
    tiles = counts(judged, candidate)
    used_frames = np.isin(np.arange(len(found.weight)), () if answer.frames_disagree else answer.excluded, invert=True)
    reason = _reason(judged, answer, tiles[:, used_frames], candidate)
    rows = rows_of(judged, answer)
    errors = row_errors(rows)
    outcome_if_accepted = IntrinsicsOutcome.NEEDED if case.free.widens else IntrinsicsOutcome.REFINED
    return Ending(
        candidate=candidate,
        reason=reason,
        tiles=tiles,
        excluded=answer.excluded,
        row_errors=errors,
        uncertainty=uncertainty_of(estimated, candidate, judged.chart),
        misfit=misfit(rows, late=estimated.is_late),
        intrinsics=_intrinsics(answer, judged, errors, reason, outcome_if_accepted),
        estimate=estimated,
        decision=decision,
    )


def _reason(case: Case, answer: Answer, tiles: Int[np.ndarray, "2 k tiles"], candidate: StereoRig) -> Reason:
    if answer.frames_disagree:
        refuse_swapped_images(case.images, answer.excluded)
        return Reason.FRAMES_DISAGREE
    if not answer.enough:
        return Reason.TOO_LITTLE_TEXTURE
    if answer.sparse and answer.decision.verdict is Verdict.GOOD:
        return Reason.CANNOT_TELL
    # Not where the search ended: along what the rows do not show, it may end anywhere.
    z, decision = drift_within_reach(case.rig, candidate, case.reach), answer.decision
    doubtful = decision.verdict is Verdict.CANNOT_TELL or not (decision.refused or decision.is_understood)
    if (at_the_edge(z) and doubtful) or (is_beyond(z) and not decision.refused):
        return Reason.REACH_EDGE
    return reason_of(decision, tiles, late=answer.estimate.is_late)


def reason_of(decision: Decision, tiles: Int[np.ndarray, "2 k tiles"], *, late: bool) -> Reason:
    """The decision in words, of tiles that have these counts before and after.

    Args:
        late: whether one of the two shutters is.
    """
    if decision.verdict is Verdict.GOOD:
        return Reason.ALREADY_GOOD
    if decision.verdict is Verdict.CANNOT_TELL:
        unexplained = Reason.LATE_SHUTTER if late else Reason.MISFIT
        return Reason.CANNOT_TELL if decision.explains else unexplained
    if loses_regions(tiles):
        return Reason.FEWER_MATCHES
    if decision.by_motion:
        return Reason.MOTION
    return Reason.RANGES if decision.by_ranges else Reason.IMPROVED


def _intrinsics(
    answer: Answer, case: Case, rows: RowErrors, reason: Reason, outcome_if_accepted: IntrinsicsOutcome
) -> Intrinsics | None:
    """What became of intrinsics that were free; None if none were."""
    estimated, theta = answer.estimate, answer.decision.theta
    if not case.free.shared:
        return None
    extrinsics_alone = estimated.chart.rig_at(estimated.with_free(case.free.axes))
    held = row_errors(_rows_at(case.of_extrinsics, answer.found, extrinsics_alone))
    if reason.accepted:
        outcome = outcome_if_accepted if case.free.intrinsics else IntrinsicsOutcome.REFINED
    else:
        outcome = IntrinsicsOutcome.REFUSED if answer.enough else IntrinsicsOutcome.NOT_SOLVED
    return intrinsics_of(
        estimated,
        theta,
        case.free.shared,
        outcome,
        fixed_px=held.after,
        freed_px=rows.after,
        shown=len(_occupied_tiles(answer.found)) / TILES_OF_A_FRAME,
        expected_px=estimated.row_error_px(theta)[10][0],
        refused=None if reason.accepted else reason,
    )


def rows_of(case: Case, answer: Answer) -> RowResiduals:
    """Row differences of the correspondences, under the initial calibration and the candidate."""
    return _rows_at(case.with_free(answer.free), answer.found, answer.estimate.chart.rig_at(answer.decision.theta))


def _occupied_tiles(found: Correspondences) -> Int[np.ndarray, "p"]:
    """Numbers of the tiles of a frame that show something."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


def _rows_at(case: Case, found: Correspondences, candidate: StereoRig) -> RowResiduals:
    """Row differences under the initial calibration and a candidate, as they are."""
    return row_residuals(case.chart, found, case.chart.coordinates_of(candidate))
