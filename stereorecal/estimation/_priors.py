"""What users may say of their calibration: nothing, that its intrinsics are exact, deviations, or a covariance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal._errors import InputError
from stereorecal._names import known
from stereorecal.estimation._calibration_prior import (
    CalibrationPrior,
    calibration_prior,
    exact_prior,
    with_scaled_boards,
)
from stereorecal.estimation._posterior import root
from stereorecal.objectives import BASELINE, RigChart

DEFAULT, EXACT = "default", "exact"
_NOT_POSITIVE = 1e-9  # of the largest eigenvalue of the correlations


@dataclass(frozen=True, eq=False)
class CalibrationCovariance:
    """How well a calibration is known, as mrcal and other calibrations with uncertainties say it.

    Attributes:
        names: of the parameters: "pitch", "yaw", "roll", "y", "z", "baseline", "left.f", "left.cx", …; those that are
            missing are as exact as they were given.
        covariance: (n, n) in their units: degrees for angles, percent of the baseline for y, z and baseline, percent
            for f and aspect, pixels for cx and cy, and coefficients as they are.

    Raises:
        InputError: if names and shape do not fit, or the matrix is not symmetric and positive definite.
    """

    names: Sequence[str]
    covariance: Float[AnyArray, "n n"]

    def __post_init__(self) -> None:
        names, covariance = tuple(self.names), np.array(self.covariance, float)
        if covariance.shape != (len(names), len(names)) or len(set(names)) < len(names):
            raise InputError(
                f"the covariance has the shape {covariance.shape} for {len(names)} names; give one row and one column "
                "for each name, and no name twice."
            )
        if not np.isfinite(covariance).all():
            raise InputError("the covariance is not finite; give it as the calibration wrote it.")
        deviations = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        correlations = covariance / deviations[:, None] / deviations
        if not np.allclose(correlations, correlations.T, rtol=0.0, atol=1e-6):
            raise InputError("the covariance is not symmetric; give it as the calibration wrote it.")
        covariance, values = 0.5 * (covariance + covariance.T), np.linalg.eigvalsh(correlations)
        if np.diag(covariance).min(initial=1.0) <= 0.0 or values.min(initial=1.0) < -_NOT_POSITIVE * values.max():
            raise InputError("the covariance is not positive definite; check its order and its units.")
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "covariance", covariance)


Prior = str | Mapping[str, float] | CalibrationCovariance | CalibrationPrior | None


def as_prior(prior: Prior, chart: RigChart, *, told_length: bool = False) -> CalibrationPrior:
    """The prior itself, for the rig of a chart.

    Args:
        told_length: something will tell the length of the baseline; where the prior does not speak of it, that may be
            wrong as the sizes of boards are.

    Raises:
        InputError: as `check_prior`.
    """
    found = _as_prior(prior, chart)
    said = prior.names if isinstance(prior, CalibrationCovariance) else prior if isinstance(prior, Mapping) else ()
    if not told_length or BASELINE in said or isinstance(prior, CalibrationPrior):
        return found
    return with_scaled_boards(found, chart)


def with_deviations(prior: CalibrationPrior, chart: RigChart, sigmas: Mapping[str, float]) -> CalibrationPrior:
    """The same with these standard deviations of some parameters, whose correlations are kept; what was as exact as
    given gets one of its own."""
    which, roots = [chart.names.index(name) for name in sigmas], []
    for one in prior.roots:
        before, factors, own = np.linalg.norm(one, axis=1), np.ones(chart.dim), np.zeros(chart.dim)
        for index, sigma in zip(which, sigmas.values(), strict=True):
            if before[index] > 0.0:
                factors[index] = sigma / before[index]
            else:
                own[index] = sigma
        roots.append(root((factors[:, None] * one) @ (factors[:, None] * one).T + np.diag(own**2)))
    return CalibrationPrior(np.stack(roots), prior.weights, means=prior.means)


def _as_prior(prior: Prior, chart: RigChart) -> CalibrationPrior:
    check_prior(prior, chart)
    if isinstance(prior, CalibrationPrior):
        return prior
    if prior is None or prior == DEFAULT:
        return calibration_prior(chart)
    if isinstance(prior, str):
        return exact_prior(chart)
    if isinstance(prior, CalibrationCovariance):
        where = [chart.names.index(name) for name in prior.names]
        covariance = np.zeros((chart.dim, chart.dim))
        covariance[np.ix_(where, where)] = prior.covariance
        return CalibrationPrior.around_given(root(covariance)[None], np.ones(1))
    return _rescaled(calibration_prior(chart), chart, prior)


def check_prior(prior: Prior, chart: RigChart | None = None) -> None:
    """Refuse what is no prior.

    Raises:
        InputError: says what to do.
    """
    if prior is None or isinstance(prior, CalibrationPrior):
        return
    if isinstance(prior, str):
        known(prior, [DEFAULT, EXACT], "prior")
        return
    if not isinstance(prior, Mapping | CalibrationCovariance):
        raise InputError(
            f'prior is {prior!r}; give "default", "exact", standard deviations by name such as {{"left.f": 0.2}} '
            "(percent), or an sr.CalibrationCovariance."
        )
    names = list(prior) if isinstance(prior, Mapping) else list(prior.names)
    for name in names if chart is not None else ():
        known(name, list(chart.names) if chart is not None else [], "parameter")
    for name, sigma in prior.items() if isinstance(prior, Mapping) else ():
        if not (isinstance(sigma, int | float) and np.isfinite(sigma) and sigma > 0.0):
            raise InputError(f"the prior of {name} is {sigma!r}; give a positive standard deviation.")


def _rescaled(prior: CalibrationPrior, chart: RigChart, sigmas: Mapping[str, float]) -> CalibrationPrior:
    """The prior with these standard deviations, its correlations kept; what is not named follows their median."""
    factors = []
    for one in prior.roots:
        deviations = np.linalg.norm(one, axis=1)
        where = {name: sigma / deviations[chart.names.index(name)] for name, sigma in sigmas.items()}
        others = float(np.median(list(where.values()))) if where else 1.0
        factors.append([where.get(name, others) for name in chart.names])
    return CalibrationPrior.around_given(prior.roots * np.array(factors)[:, :, None], prior.weights)


def is_exact(prior: Prior) -> bool:
    """Whether the intrinsics are the truth."""
    return isinstance(prior, str) and prior == EXACT
