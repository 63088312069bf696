"""How well the solution is known, in the units in which people read it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation import Estimate
from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart

NORMAL_95 = 1.96
_PART = 0.3  # of a unit direction: an axis with less is not named
OBSERVED = 0.5  # of the prior's standard deviation; above it, the answer is mostly the prior


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of the free parameters: pitch, yaw, roll in degrees, y, z in percent of the baseline.

    Attributes:
        names: of the parameters, n of them; five by default.
        covariance: (n, n), mean squares of what the truth may differ by from the candidate.
        by_chance: (n, n), of the posterior: without the way from its mean to the candidate.
        observed: (n,) which parameters the data determine; the others stay near the initial calibration.
        undetermined: directions that the data leave to the prior, in words, such as "y with pitch".
    """

    names: tuple[str, ...]
    covariance: Float[np.ndarray, "n n"]
    by_chance: Float[np.ndarray, "n n"]
    observed: Bool[np.ndarray, "n"]
    undetermined: tuple[str, ...] = ()

    @property
    def interval(self) -> Float[np.ndarray, "n"]:
        """Half widths of the 95 % intervals."""
        return NORMAL_95 * np.sqrt(np.diag(self.covariance))

    @property
    def interval_by_chance(self) -> Float[np.ndarray, "n"]:
        """The same of the posterior: where the candidate is its mean, they are equal."""
        return NORMAL_95 * np.sqrt(np.diag(self.by_chance))

    @property
    def unobserved(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not determine."""
        return tuple(name for name, observed in zip(self.names, self.observed, strict=True) if not observed)


def uncertainty(
    names: tuple[str, ...],
    posterior: Float[np.ndarray, "n n"],
    offset: Float[np.ndarray, "n"],
    drift: Float[np.ndarray, "n"],
    calibration_variance: Float[np.ndarray, "n"] | float = 0.0,
) -> Uncertainty:
    """The uncertainty of a candidate.

    Args:
        posterior: its covariance.
        offset: from the candidate to its mean.
        drift: standard deviations of the drift, before anything was seen.
        calibration_variance: variances of what the calibration left.
    """
    before = np.sqrt(drift**2 + calibration_variance)
    observed = np.diag(posterior) < (OBSERVED * before) ** 2
    weak = directions(posterior / before[:, None] / before, names)
    return Uncertainty(names, posterior + np.outer(offset, offset), posterior, observed, weak)


def uncertainty_of(estimated: Estimate, candidate: StereoRig, chart: RigChart) -> Uncertainty:
    """Of the parameters of a chart, around a candidate and marginal over all others: mean squares of what the truth may
    differ by."""
    where = [estimated.names.index(name) for name in chart.names]
    offset = (estimated.theta - estimated.chart.coordinates_of(candidate))[where]
    spread = estimated.posterior.covariance[np.ix_(where, where)]
    return uncertainty(chart.names, spread, offset, chart.prior * chart.units, estimated.prior_variance[where])


def directions(covariance: Float[np.ndarray, "n n"], free: tuple[str, ...]) -> tuple[str, ...]:
    """The directions that stay mostly as uncertain as the prior: their axes, the largest part first; each axis alone
    where as many directions as axes share the same ones.

    Args:
        covariance: each axis scaled by the prior's standard deviation.
    """
    variances, axes = np.linalg.eigh(covariance)
    found: dict[frozenset[str], list[list[str]]] = {}
    for variance, direction in zip(variances, axes.T, strict=True):
        if variance > OBSERVED**2:
            parts = np.argsort(-np.abs(direction))
            names = [free[i] for i in parts if abs(direction[i]) > _PART]
            found.setdefault(frozenset(names), []).append(names)
    alone = [name for some in found.values() if len(some) >= len(some[0]) for name in some[0]]
    together = [" with ".join(some[0]) for some in found.values() if len(some) < len(some[0])]
    return tuple(dict.fromkeys([*alone, *together]))
