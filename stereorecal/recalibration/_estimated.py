"""The end of a repair by the estimate: the candidate that loses least in rows and depth, of what may change."""

from dataclasses import replace

import numpy as np

from stereorecal.estimation import Estimate, estimate, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import RigChart, row_chart
from stereorecal.recalibration._acceptance import RowErrors, compared
from stereorecal.recalibration._consequences import Interval
from stereorecal.recalibration._evidence import Evidence, evidence
from stereorecal.recalibration._expected import Expected, expected
from stereorecal.recalibration._stages import Case
from stereorecal.recalibration._uncertainty import OBSERVED, Uncertainty, directions
from stereorecal.scoring import Correspondences


def estimated(case: Case, found: Correspondences, near: StereoRig) -> tuple[Estimate, StereoRig]:
    """The estimate, and the candidate.

    Args:
        found: with the rays that the cameras of the case's rig give.
        near: where the search ended, with those cameras.
    """
    chart = rig_parameters(case.rig)
    seen = estimate(found, case.rig, case.prior, start=chart.coordinates_of(near))
    return seen, seen.chart.rig_at(seen.with_free(case.free.names))


def facts_at(case: Case, found: Correspondences, candidate: StereoRig) -> tuple[Evidence, RowErrors]:
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
