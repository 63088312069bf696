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
from stereorecal.recalibration._unmatched import LIKELY, MOST_APART, is_sparse, unmatched, without_frames_of
from stereorecal.recalibration._windows import windows_of, without_frames
from stereorecal.scoring import Correspondences, image_quality
from stereorecal.scoring.host import refuse_swapped_images


@dataclass(frozen=True, eq=False)
class Answer:
    """What the correspondences of all frames say together, and what follows.

    Attributes:
        found: of the frames that are kept.
        estimate: of the rig that they show.
        apart: numbers of the frames that show another one.
        refused: they are too many to say which are wrong; all count then.
        free: what may change, if frames bear out that more must than the case has free.
        decision: on the initial calibration.
        sparse: they cover little of what has texture: no reason to call a calibration good.
        by_chance: so, and even the candidate leaves their rows as far apart as those of chance matches.
    """

    found: Correspondences
    estimate: Estimate
    apart: tuple[int, ...]
    refused: bool
    free: Parameters
    decision: Decision
    sparse: bool = False
    by_chance: bool = False

    @property
    def enough(self) -> bool:
        """Whether enough of the images matches for a verdict: chance matches cover little, and few places."""
        return self.found.covered >= LEAST_COVERED and len(_occupied_tiles(self.found)) >= FEWEST_PLACES


def answered(case: Case, run: StageRun, near: StereoRig, *, corners: bool) -> Answer:
    """The answer of a stage's correspondences.

    Args:
        run: that found them.
        near: where the search ended, with the cameras of the case's rig.
        corners: whether images are matched once more, through the rig that was found, where intrinsics may change:
            towards the corners, windows meet other things under other lenses.
    """
    found = run.found
    assert found is not None
    apart = unmatched(found, case.images.pairs) if len(found.weight) > 1 else ()
    seeing = int(np.any(np.asarray(without_frames_of(found, apart).weight) > 0, axis=1).sum())
    most = MOST_APART * (seeing + len(apart))
    start, tracks = rig_parameters(case.rig).coordinates_of(near), windows_of(case, found)
    view = case.images.view
    while True:
        rest = without_frames_of(found, apart)
        ranges, windows = matched_ranges(case, found, near, apart), without_frames(case, tracks, apart)
        seen = estimate(rest, case.rig, case.prior, start=start, beams=ranges, windows=windows, view=view)
        if not seen.other_rigs or len(apart) > most:
            break
        apart, start = (*apart, seen.other_rigs[0].frame), seen.theta
    if refused := len(apart) > most:
        rest = found
        ranges, windows = matched_ranges(case, found, near), without_frames(case, tracks, ())
        seen = estimate(rest, case.rig, case.prior, start=start, beams=ranges, windows=windows, view=view)
    if corners and case.free.lenses:
        seen, rest = _matched_again(case, seen, rest, run)
    free, decision = free_and_decision(case, rest, seen)
    if corners and free.lenses and not case.free.lenses:
        seen, rest = _matched_again(case, seen, rest, run)
        decision = decide(seen, free.names, case.tolerances, proven=True)
    answer = Answer(rest, seen, tuple(sorted(apart)), refused, free, decision)
    sparse = rest.covered < LIKELY and is_sparse(
        rest.covered, max(image_quality(pair).texture for pair in case.images.pairs)
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
        seen = answer is not None and answer.enough and not answer.refused and not answer.sparse
        return answer.decision.verdict if answer is not None and seen else None


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


def _matched_again(
    case: Case, seen: Estimate, found: Correspondences, run: StageRun
) -> tuple[Estimate, Correspondences]:
    """The estimate of correspondences through the rig that was estimated, in the images of a stage, and these."""
    again = matched(case.images.at(run.scale, run.stage.frames), seen.chart, seen.theta, case.matcher)
    kept = np.any(np.asarray(found.weight) > 0, axis=1)
    again = replace(again, weight=np.asarray(again.weight) * kept[:, None])
    if again.found < FEWEST:
        return seen, found
    seen = estimate(
        again, case.rig, case.prior, start=seen.theta, beams=seen.beams, windows=seen.windows, view=seen.view
    )
    return seen, again


def ended_by(case: Case, answer: Answer) -> Ending:
    """The candidate of an answer, and the verdict on it."""
    seen, decision, found = answer.estimate, answer.decision, answer.found
    taken = IntrinsicsOutcome.NEEDED if case.free.widens else IntrinsicsOutcome.REFINED
    case = replace(case, free=answer.free)
    candidate = seen.chart.rig_at(decision.theta)
    tiles = counts(case, candidate)
    kept = np.isin(np.arange(len(found.weight)), () if answer.refused else answer.apart, invert=True)
    reason = _reason(case, answer, tiles[:, kept], candidate)
    facts, rows = _evidence_at(case, found, candidate), rows_of(case, answer)
    return Ending(
        candidate,
        reason,
        tiles,
        answer.apart,
        rows,
        uncertainty_of(seen, candidate, case.chart),
        misfit(facts),
        _intrinsics(answer, case, rows, reason, taken),
        seen,
        decision,
    )


def _reason(case: Case, answer: Answer, tiles: Int[np.ndarray, "2 k tiles"], candidate: StereoRig) -> Reason:
    if answer.refused:
        refuse_swapped_images(case.images, answer.apart)
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
    answer: Answer, case: Case, rows: RowErrors, reason: Reason, taken: IntrinsicsOutcome
) -> Intrinsics | None:
    """What became of intrinsics that were free; None if none were."""
    seen, theta = answer.estimate, answer.decision.theta
    if not case.free.shared:
        return None
    facts = _evidence_at(case.of_extrinsics, answer.found, seen.chart.rig_at(seen.with_free(case.free.axes)))
    if reason.accepted:
        outcome = taken if case.free.lenses else IntrinsicsOutcome.REFINED
    else:
        outcome = IntrinsicsOutcome.REFUSED if answer.enough else IntrinsicsOutcome.NOT_SOLVED
    return intrinsics_of(
        seen,
        theta,
        case.free.shared,
        outcome,
        fixed_px=float(np.mean(facts.medians(facts.residual))),
        freed_px=rows.after,
        shown=len(_occupied_tiles(answer.found)) / TILES_OF_A_FRAME,
        expected_px=seen.row_error_px(theta)[10][0],
        refused=None if reason.accepted else reason,
    )


def rows_of(case: Case, answer: Answer) -> RowErrors:
    """Row errors of the correspondences, under the initial calibration and the candidate."""
    case = replace(case, free=answer.free)
    facts = _evidence_at(case, answer.found, answer.estimate.chart.rig_at(answer.decision.theta))
    return compared(facts, facts.medians(facts.start_residual), facts.medians(facts.residual))


def _occupied_tiles(found: Correspondences) -> Int[np.ndarray, "p"]:
    """Numbers of the tiles of a frame that show something."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


def _evidence_at(case: Case, found: Correspondences, candidate: StereoRig) -> Evidence:
    """Row differences under the initial calibration and a candidate, as they are."""
    chart = row_chart(case.rig, case.reach, case.free)
    return evidence(chart, found, chart.coordinates_of(candidate))


def uncertainty_of(seen: Estimate, candidate: StereoRig, chart: RigChart) -> Uncertainty:
    """Of the parameters of a chart, around a candidate and marginal over all others: mean squares of what the truth may
    differ by."""
    where = [seen.names.index(name) for name in chart.names]
    apart = (seen.theta - seen.chart.coordinates_of(candidate))[where]
    spread = seen.posterior.covariance[np.ix_(where, where)]
    return uncertainty(chart.names, spread, apart, chart.prior * chart.units, seen.prior_variance[where])


def expected_by(seen: Estimate, used: StereoRig, view: View, rows_px: float) -> Expected:
    """What to expect of a rig: rows over the view, which the decision tells, and depth with its 95 % interval."""
    depth = depth_by(seen, seen.chart.coordinates_of(used))
    return expected(used, seen.chart, seen.theta, seen.posterior.covariance, view, rows_px, depth)


def depth_by(seen: Estimate, used: Float[np.ndarray, "n"]) -> dict[int, Interval]:
    """The error of depth of the rig at θ = used."""
    return {distance: Interval(*ends) for distance, ends in seen.depth_error_percent(used).items()}
