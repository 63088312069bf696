"""The end of a repair by the estimate: the candidate that loses least in rows and depth, of what may change."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from stereorecal.estimation import Estimate, estimate, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import RigChart, row_chart
from stereorecal.recalibration._acceptance import Reason, RowErrors, Verdict, compared
from stereorecal.recalibration._agreement import MOST_APART, without
from stereorecal.recalibration._consequences import Interval
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence, evidence
from stereorecal.recalibration._expected import Expected, expected
from stereorecal.recalibration._intrinsics import Intrinsics, IntrinsicsOutcome
from stereorecal.recalibration._judging import judged
from stereorecal.recalibration._ranged import matched_ranges
from stereorecal.recalibration._stages import FEWEST, Case, matched
from stereorecal.recalibration._uncertainty import OBSERVED, Uncertainty, directions
from stereorecal.scoring import Correspondences

_MOST_WORSE = 0.01  # probability


def estimated(case: Case, found: Correspondences, near: StereoRig) -> tuple[Estimate, tuple[int, ...]]:
    """The estimate, and the frames that it does without, since they show another rig than the others.

    Args:
        found: with the rays that the cameras of the case's rig give.
        near: where the search ended, with those cameras.
    """
    start = rig_parameters(case.rig).coordinates_of(near)
    beams = matched_ranges(case, found, near)
    seen, apart = estimate(found, case.rig, case.prior, start=start, beams=beams), ()
    while seen.other_rigs and len(apart) < MOST_APART * len(found.weight):
        apart = (*apart, seen.other_rigs[0].frame)
        beams = matched_ranges(case, found, near, apart)
        seen = estimate(without(found, apart), case.rig, case.prior, start=seen.theta, beams=beams)
    return seen, apart


def estimated_again(
    case: Case, seen: Estimate, found: Correspondences, scale: float
) -> tuple[Estimate, Correspondences]:
    """The same, of images that are matched once more through the rig that was found: towards the corners, windows meet
    other things under other lenses.

    Args:
        scale: at which `found` were found; frames without any stay out.
    """
    again = matched(case.images.at(scale), seen.chart, seen.theta, case.matcher)
    kept = np.any(np.asarray(found.weight) > 0, axis=1)
    again = replace(again, weight=np.asarray(again.weight) * kept[:, None])
    if again.found < FEWEST:
        return seen, found
    return estimate(again, case.rig, case.prior, start=seen.theta, beams=seen.beams), again


def candidate_of(seen: Estimate, case: Case) -> StereoRig:
    """The rig that loses least, of those that differ in what is free."""
    return seen.chart.rig_at(seen.with_free(case.free.names))


def refined(seen: Estimate, case: Case, found: Correspondences, rows: RowErrors, said: Reason) -> Intrinsics | None:
    """What became of intrinsics that were free; None if none were."""
    names = case.free.shared
    if not names:
        return None
    where = [seen.names.index(name) for name in names]
    held = seen.chart.rig_at(seen.with_free(case.free.axes))
    fixed = _facts_at(case.of_extrinsics, found, held)[1]
    low, high = seen.intervals[where].T
    before = seen.posterior.covariance[where, where]
    return Intrinsics(
        outcome=IntrinsicsOutcome.REFINED if said.accepted else IntrinsicsOutcome.REFUSED,
        names=names,
        units=tuple(seen.units[index] for index in where),
        change=seen.with_free(case.free.names)[where],
        interval=0.5 * (high - low),
        undetermined=tuple(
            name
            for name, now, given in zip(names, before, seen.prior_variance[where], strict=True)
            if now > OBSERVED**2 * given
        ),
        fixed_px=fixed.after,
        freed_px=rows.after,
        fixed_elsewhere_px=float("nan"),
        freed_elsewhere_px=float("nan"),
        shown=float(len(np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)))
        / TILES_OF_A_FRAME,
        expected_px=seen.row_error_px(seen.with_free(case.free.names)).get(10, (float("nan"),))[0],
        refused=None if said.accepted else said,
    )


def judged_by(
    seen: Estimate,
    case: Case,
    found: Correspondences,
    candidate: StereoRig,
    tiles: Int[np.ndarray, "2 k tiles"],
    said: Verdict,
) -> tuple[Verdict, RowErrors]:
    """The verdict on a candidate, and its row errors against those of the initial rig.

    Args:
        tiles: counts under the initial calibration and the candidate.
        said: of the extrinsics alone, as the search found them. Where intrinsics may change, a candidate that these
            cannot reach is accepted if it passes the same rules and is, by the estimate, hardly worse than the initial
            rig in rows or in depth.
    """
    facts, rows = _facts_at(case, found, candidate)
    if case.free.lenses and not said.reason.accepted:
        by_all, _ = judged(
            facts, case.free.names, len(case.free.axes), tiles, rows, found.covered, settled=case.free.shared
        )
        worse = seen.probability_worse(seen.chart.coordinates_of(candidate))
        if by_all.reason.accepted and worse < _MOST_WORSE:
            return by_all, rows
    return said, rows


def _facts_at(case: Case, found: Correspondences, candidate: StereoRig) -> tuple[Evidence, RowErrors]:
    """The evidence at a candidate, and its row errors against those of the initial rig, as they are: the candidate
    does not follow single regions, so none is held out."""
    chart = row_chart(case.rig, case.reach, case.free)
    facts = evidence(chart, found, chart.coordinates_of(candidate))
    rows = compared(facts, facts.medians(facts.start_residual), facts.medians(facts.residual))
    return facts, rows


def uncertainty_of(seen: Estimate, candidate: StereoRig, chart: RigChart) -> Uncertainty:
    """Of the parameters of a chart, around a candidate and marginal over all others: mean squares of what the truth may
    differ by."""
    where = [seen.names.index(name) for name in chart.names]
    apart = (seen.theta - seen.chart.coordinates_of(candidate))[where]
    spread = seen.posterior.covariance[np.ix_(where, where)]
    sigmas = chart.prior * chart.units
    observed = np.sqrt(np.diag(spread)) < OBSERVED * sigmas
    weak = directions(spread / sigmas[:, None] / sigmas, chart.names)
    return Uncertainty(chart.names, spread + np.outer(apart, apart), spread, observed, weak)


def expected_by(seen: Estimate, used: StereoRig, view: View) -> Expected:
    """What to expect of a rig: rows over the view, and depth with its 95 % interval."""
    rows = expected(used, seen.chart, seen.theta, seen.posterior.covariance, view)
    depth = {
        distance: Interval(*ends)
        for distance, ends in seen.depth_error_percent(seen.chart.coordinates_of(used)).items()
    }
    return replace(rows, depth_percent=depth)
