"""The one least squares: Gauss-Newton on rows of groups, with the evidence choosing priors and misfit on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._confounders import Fitted, fits_with_rivals
from stereorecal.estimation._delay import Delay, fit_with_delay
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._explanations import (
    NOTHING,
    Explanation,
    Hypothesis,
    best_of,
    evidence_of,
    explained_by,
    explanations,
    mixture,
)
from stereorecal.estimation._groups import grouped
from stereorecal.estimation._lens_field import within_field
from stereorecal.estimation._linear_groups import LinearGroups, linear_groups
from stereorecal.estimation._measured import Measured
from stereorecal.estimation._misfit import COMMON, DEVIATIONS
from stereorecal.estimation._posterior import Posterior
from stereorecal.objectives import RigChart
from stereorecal.scoring import Correspondences

_FEWEST = 6  # groups: from fewer nothing is to be learnt of twenty parameters
_ROUNDS = 8
_REGROUPED = 3  # times; then outliers are what they are
_SETTLED = 0.05  # standard deviations of θ
_LIKELY = 1e-3  # of the weight of all hypotheses: one of less is not asked again


@dataclass(frozen=True, eq=False)
class Fit:
    """The solution.

    Attributes:
        posterior: of θ.
        rows: linear near it; None where there are too few.
        misfit: the most probable deviations of the field of each frame and of the common one, pixels.
        prior_variance: (n,) of its error, before any image was seen, by the weights that its covariances have after.
        best: the most probable explanation.
        delay: of the right shutter; None where motion says nothing of it.
        hypotheses: those that have a say.
    """

    posterior: Posterior
    rows: LinearGroups | None
    misfit: tuple[float, float]
    prior_variance: Float[np.ndarray, "n"]
    best: Explanation
    delay: Delay | None = None
    hypotheses: tuple[Hypothesis, ...] = ()


def fit(
    found: Correspondences,
    chart: RigChart,
    prior: CalibrationPrior,
    start: Float[np.ndarray, "n"] | None,
    measured: Measured,
) -> Fit:
    """Solve: a prior and a misfit for a round are the evidence's best, and all of them are mixed after the last.

    Args:
        found: with the rays that the cameras of the chart's rig give.
        start: θ to begin at; None: 0.
        measured: besides rows.
    """
    theta = np.zeros(chart.dim) if start is None else start
    misfit, which = (DEVIATIONS[2], 0.0), len(prior.roots) // 2
    groups = grouped(found, chart, theta)
    if len(groups) < _FEWEST:
        return _fit_without_rows(chart, prior, measured.likelihoods(chart, theta, prior))
    rows = linear_groups(groups, chart, theta, prior, measured)
    step = np.zeros(chart.dim)
    for number in range(_ROUNDS):
        best, kind = best_of(_searched(rows, prior, misfit, which))
        misfit, which = best.misfit, best.prior
        deviations = np.sqrt(np.maximum(np.diag(best.found.covariance(kind)), 1e-30))
        last, step = step, (best.found.means[kind] - theta) / deviations
        if number and np.abs(step).max() < _SETTLED:  # from the second round on, groups that err alone have less say
            break
        # Where rows bend along what they hardly tell, whole steps go to and fro.
        move = (0.5 if step @ last < 0.0 else 1.0) * step * deviations
        theta = theta + within_field(found, chart, theta, move)
        if number < _REGROUPED:
            groups = grouped(found, chart, theta)
        rows = linear_groups(groups, chart, theta, prior, measured, None if number < _REGROUPED else rows.likelihoods)
        rows = replace(rows, deviation=rows.robust(sum(misfit), theta))
    misfits = _neighbouring_misfits(misfit, len(rows.frames) > 1)
    alone = explanations(rows, prior, range(len(prior.roots)), misfits)
    fitted = [Fitted(Hypothesis(rows, best_of(alone)[0].misfit, NOTHING, 0.0), alone)]
    fitted += fits_with_rivals(rows, chart, prior, alone)
    delay = None
    if (late := fit_with_delay(rows, chart, prior, alone)) is not None:
        delay = late.delay([one for some in fitted for one in some.several])
        fitted.append(late.fitted)
        rows = late.rows if delay.likely else rows
    several = [one for some in fitted for one in some.several]
    evidence = np.array([evidence_of([one]) for one in several])
    weights = np.exp(evidence - np.logaddexp.reduce(evidence))
    variances = np.stack([np.sum(prior.roots[one.prior] ** 2, axis=1) for one in several])
    best, least = best_of(several)[0], np.logaddexp.reduce(evidence) + np.log(_LIKELY)
    likely = tuple(some.hypothesis for some in fitted if evidence_of(some.several) > least)
    return Fit(mixture(several), rows, best.misfit, weights @ variances, best, delay, likely)


def _fit_without_rows(chart: RigChart, prior: CalibrationPrior, likelihoods: Sequence[tuple[float, Normal]]) -> Fit:
    """The fit where there are no rows: by the prior, and what is measured besides."""
    flat = Normal(np.zeros((chart.dim, chart.dim)), np.zeros(chart.dim), 0.0)
    several = explained_by({(0.0, 0.0): flat}, likelihoods, prior, range(len(prior.roots)))
    variances = prior.weights @ np.sum(prior.roots**2, axis=2)
    return Fit(mixture(several), None, (0.0, 0.0), variances, best_of(several)[0])


def _searched(
    rows: LinearGroups, prior: CalibrationPrior, misfit: tuple[float, float], which: int
) -> list[Explanation]:
    """The best misfit for a prior, then the best prior for that misfit."""
    found = explanations(rows, prior, [which], [(d, misfit[1]) for d in DEVIATIONS])
    if len(rows.frames) > 1:
        deviation = best_of(found)[0].misfit[0]
        found += explanations(rows, prior, [which], [(deviation, c) for c in COMMON])
    best = best_of(found)[0]
    return found + explanations(rows, prior, range(len(prior.roots)), [best.misfit])


def _neighbouring_misfits(misfit: tuple[float, float], several: bool) -> list[tuple[float, float]]:
    """The misfits whose fits are mixed: the best one and its neighbours."""

    def neighbours(value: float, grid: tuple[float, ...]) -> tuple[float, ...]:
        at = grid.index(value)
        return grid[max(at - 1, 0) : at + 2]

    return [
        (d, c)
        for d in neighbours(misfit[0], DEVIATIONS)
        for c in (neighbours(misfit[1], COMMON) if several else (0.0,))
    ]
