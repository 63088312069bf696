"""What became of freed intrinsics."""

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal.decision import Reason
from stereorecal.estimation import Estimate
from stereorecal.recalibration._uncertainty import OBSERVED


class IntrinsicsOutcome(enum.Enum):
    """What became of freed intrinsics; the value is the message."""

    REFINED = "the intrinsics were refined"
    NOT_HERE = "the intrinsics were refined with other recordings, but this one does without"
    REFUSED = "the intrinsics stay as given"
    NOT_SOLVED = "the intrinsics stay: too little of the images matches"


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """The shared parameters of a repair that freed more than extrinsics; all recordings have the same.

    Attributes:
        outcome: whether they were taken, and why not.
        names, units: of the parameters, p of them.
        change, interval: (p,) found, and half widths of the 95 % intervals, in those units; whether taken or not.
        undetermined: names of those that stay about as uncertain as their priors.
        fixed_px, freed_px: mean over tiles of the median |row difference|, with the intrinsics as given and freed.
        shown: share of the places of the view that hold correspondences.
        expected_px: root mean square of the rows to expect over the view with freed intrinsics, of the recording that
            is surest: others add what they do not know of their own extrinsics.
        refused: why the calibration that they belong to was refused, where it was that.
    """

    outcome: IntrinsicsOutcome
    names: tuple[str, ...]
    units: tuple[str, ...]
    change: Float[np.ndarray, "p"]
    interval: Float[np.ndarray, "p"]
    undetermined: tuple[str, ...]
    fixed_px: float
    freed_px: float
    shown: float
    expected_px: float
    refused: Reason | None = None

    @property
    def taken(self) -> bool:
        """True if the calibration to use has them."""
        return self.outcome is IntrinsicsOutcome.REFINED

    @property
    def changed(self) -> bool:
        """True if they are taken, and are those of a camera, and not only the length of the baseline."""
        return self.taken and any("." in name for name in self.names)

    def not_applied(self, why: Reason) -> "Intrinsics":
        """The same for a recording whose calibration does without, where others took them."""
        return replace(self, outcome=IntrinsicsOutcome.NOT_HERE, refused=why) if self.taken else self

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        by_name = {
            name: {"unit": unit, "change": change, "interval_95": interval}
            for name, unit, change, interval in zip(self.names, self.units, self.change, self.interval, strict=True)
        }
        names = ("fixed_px", "freed_px", "shown", "expected_px")
        return json_data(
            {
                "outcome": self.outcome.name.lower(),
                "verdict": self.outcome.value,
                "refused": self.refused and self.refused.name.lower(),
                "parameters": by_name,
                "undetermined": self.undetermined,
                **{name: getattr(self, name) for name in names},
            }
        )

    def __str__(self) -> str:
        parts = [self.outcome.value, *([self.refused.value] if self.refused else [])]
        if any("." in name for name in self.names):
            parts.append(
                f"rows of matches differ by {self.fixed_px:.2f} px with those given, {self.freed_px:.2f} px with others"
            )
        lengths = zip(self.names, self.change, self.interval, strict=True)
        parts += [f"{name} {change:+.3f} ± {wide:.3f} %" for name, change, wide in lengths if "." not in name]
        return "; ".join(parts)


def intrinsics_of(
    estimated: Estimate,
    theta: Float[np.ndarray, "n"],
    names: Sequence[str],
    outcome: IntrinsicsOutcome,
    *,
    fixed_px: float,
    freed_px: float,
    shown: float,
    expected_px: float,
    refused: Reason | None = None,
) -> Intrinsics:
    """What became of some parameters in an estimate.

    Args:
        theta: the candidate.
        others: of `Intrinsics`, by its names.
    """
    where = [estimated.names.index(name) for name in names]
    (low, high), after = estimated.intervals[where].T, np.diag(estimated.posterior.covariance)[where]
    return Intrinsics(
        outcome=outcome,
        names=tuple(names),
        units=tuple(estimated.units[index] for index in where),
        change=theta[where],
        interval=0.5 * (high - low),
        undetermined=tuple(
            name
            for name, posterior_variance, prior_variance in zip(
                names, after, estimated.prior_variance[where], strict=True
            )
            if posterior_variance > OBSERVED**2 * prior_variance
        ),
        fixed_px=fixed_px,
        freed_px=freed_px,
        shown=shown,
        expected_px=expected_px,
        refused=refused,
    )
