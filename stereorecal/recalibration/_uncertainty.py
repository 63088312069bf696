"""How well the solution is known, in the units in which people read it; and what became of freed intrinsics."""

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._arrays import json_data
from stereorecal.decision import Reason
from stereorecal.estimation import Estimate
from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameter

NORMAL_95 = 1.96
_PART = 0.3  # of a unit direction: an axis with less is not named
OBSERVED = 0.5  # of the prior's standard deviation; above it, the answer is mostly the prior


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """The uncertainty of the free parameters: pitch, yaw, roll in degrees, y, z in percent of the baseline.

    Attributes:
        names: of the parameters, n of them; five by default.
        covariance: (n, n), mean squares of what the truth may differ by from the candidate.
        observed: (n,) which parameters the data determine; the others stay near the initial calibration.
        undetermined: directions that the data leave to the prior, in words, such as "y with pitch".
    """

    names: tuple[str, ...]
    covariance: Float[np.ndarray, "n n"]
    observed: Bool[np.ndarray, "n"]
    undetermined: tuple[str, ...] = ()

    @property
    def interval(self) -> Float[np.ndarray, "n"]:
        """Half widths of the 95 % intervals around the candidate: one that keeps depth lies far from the posterior's
        mean."""
        return NORMAL_95 * np.sqrt(np.diag(self.covariance))

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
    return Uncertainty(names, posterior + np.outer(offset, offset), observed, weak)


def uncertainty_of(estimated: Estimate, candidate: StereoRig, parameters: Sequence[Parameter]) -> Uncertainty:
    """The uncertainty of some parameters, around a candidate and marginal over all others: mean squares of what the
    truth may differ by."""
    names, drift = tuple(one.name for one in parameters), np.array([one.sigma for one in parameters])
    where = [estimated.names.index(name) for name in names]
    offset = (estimated.theta - estimated.chart.coordinates_of(candidate))[where]
    spread = estimated.posterior.covariance[np.ix_(where, where)]
    return uncertainty(names, spread, offset, drift, estimated.prior_variance[where])


def directions(covariance: Float[np.ndarray, "n n"], free: tuple[str, ...]) -> tuple[str, ...]:
    """The directions that stay mostly as uncertain as the prior: their axes, the largest part first; each axis alone
    where as many directions as axes share the same ones; each axis is scaled by the prior's standard deviation."""
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


class IntrinsicsOutcome(enum.Enum):
    """What became of freed intrinsics; the value is the message."""

    REFINED = "the intrinsics were refined"
    APART = "the intrinsics were refined by this recording alone, without the others"
    NOT_HERE = "the intrinsics were refined with other recordings, but this one does without"
    REFUSED = "the intrinsics stay as given"


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """The shared parameters of a repair that freed more than extrinsics; recordings that share them have the same.

    Attributes:
        outcome: whether they were taken, and why not.
        names, units: of the parameters, p of them.
        change, interval: (p,) found, and half widths of the 95 % intervals, in those units; whether taken or not.
        undetermined: names of those that stay about as uncertain as their priors.
        refused: why the calibration that they belong to was refused, where it was that.
    """

    outcome: IntrinsicsOutcome
    names: tuple[str, ...]
    units: tuple[str, ...]
    change: Float[np.ndarray, "p"]
    interval: Float[np.ndarray, "p"]
    undetermined: tuple[str, ...]
    refused: Reason | None = None

    @property
    def taken(self) -> bool:
        """True if the calibration to use has them."""
        return self.outcome in (IntrinsicsOutcome.REFINED, IntrinsicsOutcome.APART)

    @property
    def changed(self) -> bool:
        """True if they are taken, and are those of a camera, and not only the length of the baseline."""
        return self.taken and any("." in name for name in self.names)

    def of(self, names: Sequence[str]) -> "Intrinsics":
        """The same of some parameters."""
        where = [self.names.index(name) for name in names]
        units, weak = tuple(self.units[index] for index in where), tuple(n for n in self.undetermined if n in names)
        return Intrinsics(
            self.outcome, tuple(names), units, self.change[where], self.interval[where], weak, self.refused
        )

    def not_applied(self, why: Reason) -> "Intrinsics":
        """The same for a recording whose calibration does without, where others took them."""
        return replace(self, outcome=IntrinsicsOutcome.NOT_HERE, refused=why) if self.taken else self

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        by_name = {
            name: {"unit": unit, "change": change, "interval_95": interval}
            for name, unit, change, interval in zip(self.names, self.units, self.change, self.interval, strict=True)
        }
        return json_data(
            {
                "outcome": self.outcome.name.lower(),
                "verdict": self.outcome.value,
                "refused": self.refused and self.refused.name.lower(),
                "parameters": by_name,
                "undetermined": self.undetermined,
            }
        )

    def __str__(self) -> str:
        parts = [self.outcome.value, *([self.refused.value] if self.refused else [])]
        lengths = zip(self.names, self.change, self.interval, strict=True)
        parts += [f"{name} {change:+.3f} ± {wide:.3f} %" for name, change, wide in lengths if "." not in name]
        return "; ".join(parts)


def intrinsics_of(
    estimated: Estimate,
    theta: Float[np.ndarray, "n"],
    names: Sequence[str],
    outcome: IntrinsicsOutcome,
    refused: Reason | None = None,
) -> Intrinsics:
    """What became of some parameters in an estimate, of which θ is the candidate."""
    where = [estimated.names.index(name) for name in names]
    (low, high), after = estimated.intervals[where].T, np.diag(estimated.posterior.covariance)[where]
    weak = after > OBSERVED**2 * estimated.prior_variance[where]
    return Intrinsics(
        outcome,
        tuple(names),
        tuple(estimated.units[index] for index in where),
        theta[where],
        0.5 * (high - low),
        tuple(name for name, one in zip(names, weak, strict=True) if one),
        refused,
    )
