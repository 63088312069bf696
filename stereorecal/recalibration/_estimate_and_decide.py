"""The end of a repair by the estimate: the candidate that loses least in rows and depth, and the one decision."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import Decision, Verdict, decide
from stereorecal.estimation import Estimate, estimate, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import Parameters, RigChart, row_chart
from stereorecal.recalibration._acceptance import (
    FALSE,
    FEWEST_PLACES,
    LEAST_COVERED,
    Reason,
    RowErrors,
    at_the_edge,
    compared,
    loses_regions,
)
from stereorecal.recalibration._default_free import free_and_decision
from stereorecal.recalibration._expected import Expected, expected
from stereorecal.recalibration._freed_intrinsics import Intrinsics, IntrinsicsOutcome, intrinsics_of
from stereorecal.recalibration._interval import Interval
from stereorecal.recalibration._ranges_of_case import matched_ranges
from stereorecal.recalibration._regional_misfit import misfit
from stereorecal.recalibration._row_evidence import TILES_OF_A_FRAME, Evidence, evidence
from stereorecal.recalibration._schedule import ScoreKind, Stage
from stereorecal.recalibration._stage_result import Ending, counts
from stereorecal.recalibration._stages import FEWEST, Case, StageRun, matched
from stereorecal.recalibration._uncertainty import Uncertainty, uncertainty
from stereorecal.recalibration._unmatched import LIKELY, MOST_EXCLUDED, is_sparse, unmatched, without_frames_of
from stereorecal.recalibration._windows import windows_of, without_frames
from stereorecal.scoring import Correspondences, image_quality
from stereorecal.scoring.host import refuse_swapped_images


@dataclass(frozen=True, eq=False)
class Answer:
    """What the correspondences of all frames say together, and what follows.

    Attributes:
        found: of the frames that are kept.
        estimate: of the rig that they show.
        excluded: numbers of the frames that show another rig.
        refused: they are too many to say which are wrong; all count then.
        free: what may change, if frames bear out that more must than the case has free.
        decision: on the initial calibration.
        sparse: they cover little of what has texture: no reason to call a calibration good.
        by_chance: so, and even the candidate leaves their rows as far apart as those of chance matches.
    """

    found: Correspondences
    estimate: Estimate
    excluded: tuple[int, ...]
    refused: bool
    free: Parameters
    decision: Decision
    sparse: bool = False
    by_chance: bool = False

    @property
    def enough(self) -> bool:
        """Whether enough of the images matches for a verdict: chance matches cover little, and few places."""
        return self.found.covered >= LEAST_COVERED and len(_occupied_tiles(self.found)) >= FEWEST_PLACES


def answered(case: Case, run: StageRun, end_rig: StereoRig, *, corners: bool) -> Answer:
    """The answer of a stage's correspondences.

    Args:
        run: that found them.
        end_rig: where the search ended, with the cameras of the case's rig.
        corners: whether images are matched once more, through the rig that was found, where intrinsics may change:
            towards the corners, windows meet other things under other lenses.
    """
    found = run.found
    assert found is not None
    excluded_frames = unmatched(found, case.images.pairs) if len(found.weight) > 1 else ()
    seeing = int(np.any(np.asarray(without_frames_of(found, excluded_frames).weight) > 0, axis=1).sum())
    most = MOST_EXCLUDED * (seeing + len(excluded_frames))
    start, tracks = rig_parameters(case.rig).coordinates_of(end_rig), windows_of(case, found)
    view = case.images.view
    while True:
        used_matches = without_frames_of(found, excluded_frames)
        ranges, windows = (
            matched_ranges(case, found, end_rig, excluded_frames),
            without_frames(case, tracks, excluded_frames),
        )
        estimated = estimate(used_matches, case.rig, case.prior, start=start, ranges=ranges, windows=windows, view=view)
        if not estimated.other_rigs or len(excluded_frames) > most:
            break
        excluded_frames, start = (*excluded_frames, estimated.other_rigs[0].frame), estimated.theta
    if refused := len(excluded_frames) > most:
        used_matches = found
        ranges, windows = matched_ranges(case, found, end_rig), without_frames(case, tracks, ())
        estimated = estimate(used_matches, case.rig, case.prior, start=start, ranges=ranges, windows=windows, view=view)
    if corners and case.free.lenses:
        estimated, used_matches = _rematched(case, estimated, used_matches, run)
    free, decision = free_and_decision(case, used_matches, estimated)
    if corners and free.lenses and not case.free.lenses:
        estimated, used_matches = _rematched(case, estimated, used_matches, run)
        decision = decide(estimated, free.names, case.tolerances, proven=True)
    answer = Answer(used_matches, estimated, tuple(sorted(excluded_frames)), refused, free, decision)
    sparse = used_matches.covered < LIKELY and is_sparse(
        used_matches.covered, max(image_quality(pair).texture for pair in case.images.pairs)
    )
    return replace(answer, sparse=sparse, by_chance=sparse and rows_of(case, answer).after > FALSE)


@dataclass(frozen=True, eq=False)
class Look:
    """One look at the images through a calibration, without any search.

    Attributes:
        run: what was done, as a stage of a schedule.
        answer: of its correspondences; None if there are too few, or they cover too little.
    """

    run: StageRun
    answer: Answer | None

    @property
    def paid(self) -> StageRun:
        """What was done, its cost counted elsewhere: no budget pays for a look."""
        return replace(self.run, matching_cost=0.0)

    @property
    def cost(self) -> float:
        """Units that it took."""
        return self.run.cost

    @property
    def repairs(self) -> bool:
        """Whether it is sure of a repair that leaves no rows misaligned: where a rig is so far off that rows are not
        searched there, a look sees what fits by chance."""
        return self.verdict is Verdict.REPAIR and self.answer is not None and self.answer.decision.explains

    @property
    def covered(self) -> float:
        """By correspondences, share of the frame that shows most."""
        return 0.0 if self.run.found is None else self.run.found.covered

    @property
    def verdict(self) -> Verdict | None:
        """On the calibration; None if too little is seen for one."""
        answer = self.answer
        conclusive = answer is not None and answer.enough and not answer.refused and not answer.sparse
        return answer.decision.verdict if answer is not None and conclusive else None


def look_at(case: Case, stage: Stage) -> Look | None:
    """Look at the images as a stage does; None if it has no correspondences.

    Args:
        case: with a disparity range.
    """
    if stage.score is not ScoreKind.EPIPOLAR:
        return None
    data, chart = case.images.at(case.scale_of(stage), stage.frames), case.of_extrinsics.chart
    found = matched(data, chart, np.zeros(chart.dim), case.matcher)
    run = StageRun(stage, case.scale_of(stage), case.rig, case.rig, (), np.zeros((0, 7)), data.cost, found)
    few = found.found < FEWEST or found.covered < LEAST_COVERED
    return Look(run, None if few else answered(case, run, case.rig, corners=False))


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
        ranges=estimated.beams,
        windows=estimated.windows,
        view=estimated.view,
    )
    return estimated, rematched


def ended_by(case: Case, answer: Answer) -> Ending:
    """The candidate of an answer, and the verdict on it."""
    estimated, decision, found = answer.estimate, answer.decision, answer.found
    outcome_if_accepted = IntrinsicsOutcome.NEEDED if case.free.widens else IntrinsicsOutcome.REFINED
    case = replace(case, free=answer.free)
    candidate = estimated.chart.rig_at(decision.theta)
    tiles = counts(case, candidate)
    used_frames = np.isin(np.arange(len(found.weight)), () if answer.refused else answer.excluded, invert=True)
    reason = _reason(case, answer, tiles[:, used_frames], candidate)
    evidence_at_candidate, rows = _evidence_at(case, found, candidate), rows_of(case, answer)
    return Ending(
        candidate,
        reason,
        tiles,
        answer.excluded,
        rows,
        uncertainty_of(estimated, candidate, case.chart),
        misfit(evidence_at_candidate),
        _intrinsics(answer, case, rows, reason, outcome_if_accepted),
        estimated,
        decision,
    )


def _reason(case: Case, answer: Answer, tiles: Int[np.ndarray, "2 k tiles"], candidate: StereoRig) -> Reason:
    if answer.refused:
        refuse_swapped_images(case.images, answer.excluded)
        return Reason.FRAMES_DISAGREE
    if not answer.enough:
        return Reason.TOO_LITTLE_TEXTURE
    if answer.sparse and answer.decision.verdict is Verdict.GOOD:
        return Reason.CANNOT_TELL
    # Not where the search ended: along what the rows do not show, it may end anywhere.
    z, decision = case.of_extrinsics.chart.coordinates(np.asarray(candidate.extrinsics)), answer.decision
    if at_the_edge(z) and (decision.verdict is Verdict.CANNOT_TELL or not (decision.refused or decision.explains)):
        return Reason.REACH_EDGE
    return reason_of(decision, tiles)


def reason_of(decision: Decision, tiles: Int[np.ndarray, "2 k tiles"]) -> Reason:
    """The decision in words, of tiles that have these counts before and after."""
    if decision.verdict is Verdict.GOOD:
        return Reason.ALREADY_GOOD
    if decision.verdict is Verdict.CANNOT_TELL:
        return Reason.CANNOT_TELL if decision.explains else Reason.MISFIT
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
    fixed_evidence = _evidence_at(
        case.of_extrinsics, answer.found, estimated.chart.rig_at(estimated.with_free(case.free.axes))
    )
    if reason.accepted:
        outcome = outcome_if_accepted if case.free.lenses else IntrinsicsOutcome.REFINED
    else:
        outcome = IntrinsicsOutcome.REFUSED if answer.enough else IntrinsicsOutcome.NOT_SOLVED
    return intrinsics_of(
        estimated,
        theta,
        case.free.shared,
        outcome,
        fixed_px=float(np.mean(fixed_evidence.medians(fixed_evidence.residual))),
        freed_px=rows.after,
        shown=len(_occupied_tiles(answer.found)) / TILES_OF_A_FRAME,
        expected_px=estimated.row_error_px(theta)[10][0],
        refused=None if reason.accepted else reason,
    )


def rows_of(case: Case, answer: Answer) -> RowErrors:
    """Row errors of the correspondences, under the initial calibration and the candidate."""
    case = replace(case, free=answer.free)
    evidence_at_candidate = _evidence_at(case, answer.found, answer.estimate.chart.rig_at(answer.decision.theta))
    return compared(
        evidence_at_candidate,
        evidence_at_candidate.medians(evidence_at_candidate.start_residual),
        evidence_at_candidate.medians(evidence_at_candidate.residual),
    )


def _occupied_tiles(found: Correspondences) -> Int[np.ndarray, "p"]:
    """Numbers of the tiles of a frame that show something."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


def _evidence_at(case: Case, found: Correspondences, candidate: StereoRig) -> Evidence:
    """Row differences under the initial calibration and a candidate, as they are."""
    chart = row_chart(case.rig, case.reach, case.free)
    return evidence(chart, found, chart.coordinates_of(candidate))


def uncertainty_of(estimated: Estimate, candidate: StereoRig, chart: RigChart) -> Uncertainty:
    """Of the parameters of a chart, around a candidate and marginal over all others: mean squares of what the truth may
    differ by."""
    where = [estimated.names.index(name) for name in chart.names]
    offset = (estimated.theta - estimated.chart.coordinates_of(candidate))[where]
    spread = estimated.posterior.covariance[np.ix_(where, where)]
    return uncertainty(chart.names, spread, offset, chart.prior * chart.units, estimated.prior_variance[where])


def expected_by(estimated: Estimate, used: StereoRig, view: View, rows_px: float) -> Expected:
    """What to expect of a rig: rows over the view, which the decision tells, and depth with its 95 % interval."""
    depth = depth_by(estimated, estimated.chart.coordinates_of(used))
    return expected(used, estimated.chart, estimated.theta, estimated.posterior.covariance, view, rows_px, depth)


def depth_by(estimated: Estimate, used: Float[np.ndarray, "n"]) -> dict[int, Interval]:
    """The error of depth of the rig at θ = used."""
    return {distance: Interval(*ends) for distance, ends in estimated.depth_error_percent(used).items()}
