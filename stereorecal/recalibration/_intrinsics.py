"""Whether freed intrinsics are taken: judged, like extrinsics, on what took no part."""

import enum
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._plain import plain

MOST_EXPECTED = 0.1  # pixels of row over the view: less no matcher notices
LEAST_SHOWN = 0.6  # of the places of the view
_GAIN = 0.005  # pixels of row error, over all recordings
_SIGNIFICANT = 3.0  # standard errors


class IntrinsicsOutcome(enum.Enum):
    """What became of freed intrinsics; the value is the message."""

    REFINED = "the intrinsics were refined: rows that took no part lie closer under them"
    NO_GAIN = "the intrinsics stay: under others, rows that took no part lie no closer"
    ELSEWHERE_WORSE = "the intrinsics stay: on recordings or frames that took no part, rows lie no closer under others"
    REGIONS_WORSE = "the intrinsics stay: others leave regions of the images worse"
    TOO_LITTLE_SHOWN = "the intrinsics stay: too little of the view is covered; add scenes with texture up to the edges"
    TOO_UNCERTAIN = "the intrinsics stay: the scenes do not determine them; add scenes at other depths and places"
    NOT_HERE = "the intrinsics were refined with other recordings, but the calibration of this one stays as it was"
    NOT_SOLVED = "the intrinsics stay: too little of the images matches"


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """The shared parameters of a repair that freed more than extrinsics; all recordings have the same.

    Attributes:
        outcome: whether they were taken, and why not.
        names, units: of the parameters, p of them.
        change, interval: (p,) found, and half widths of the 95 % intervals, in those units; whether taken or not.
        undetermined: names of those that stay about as uncertain as their priors.
        fixed_px, freed_px: mean over tiles of the median |row difference|, by solutions that have not seen the tile's
            place, with the intrinsics as given and freed.
        fixed_elsewhere_px, freed_elsewhere_px: the same by intrinsics that have not seen the recording (or, of one
            recording, the frame); NaN where there is nothing else.
        shown: share of the places of the view that hold correspondences.
        expected_px: root mean square of the rows to expect over the view with freed intrinsics.
    """

    outcome: IntrinsicsOutcome
    names: tuple[str, ...]
    units: tuple[str, ...]
    change: Float[np.ndarray, "p"]
    interval: Float[np.ndarray, "p"]
    undetermined: tuple[str, ...]
    fixed_px: float
    freed_px: float
    fixed_elsewhere_px: float
    freed_elsewhere_px: float
    shown: float
    expected_px: float

    @property
    def taken(self) -> bool:
        """True if the calibration to use has them."""
        return self.outcome is IntrinsicsOutcome.REFINED

    @property
    def not_here(self) -> "Intrinsics":
        """The same for a recording whose calibration stays, where others took them."""
        return replace(self, outcome=IntrinsicsOutcome.NOT_HERE) if self.taken else self

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        by_name = {
            name: {"unit": unit, "change": change, "interval_95": interval}
            for name, unit, change, interval in zip(self.names, self.units, self.change, self.interval, strict=True)
        }
        names = ("fixed_px", "freed_px", "fixed_elsewhere_px", "freed_elsewhere_px", "shown", "expected_px")
        return plain(
            {
                "outcome": self.outcome.name.lower(),
                "verdict": self.outcome.value,
                "parameters": by_name,
                "undetermined": self.undetermined,
                **{name: getattr(self, name) for name in names},
            }
        )

    def __str__(self) -> str:
        lines = [
            f"{self.outcome.value} ({self.fixed_px:.3f} px as given, {self.freed_px:.3f} px freed)",
            *(
                f"{name:<10} changed by {change:+9.4f} ± {interval:.4f} {unit}".rstrip()
                for name, unit, change, interval in zip(self.names, self.units, self.change, self.interval, strict=True)
                if self.taken
            ),
        ]
        if self.taken and self.undetermined:
            lines.append(f"as uncertain as before: {', '.join(self.undetermined)}")
        return "\n".join(lines)


def outcome(
    gain: Float[np.ndarray, "p"], elsewhere: float, worse: float, shown: float, expected_px: float
) -> IntrinsicsOutcome:
    """What becomes of freed intrinsics.

    Args:
        gain: in row error at each place, by solutions that have not seen it.
        elsewhere: gain on recordings that took no part; NaN where there are none.
        worse: share of the regions that are worse than with the intrinsics as given.
        shown, expected_px: see `Intrinsics`. Pixels are those of the images in which rows were measured.
    """
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
    if shown < LEAST_SHOWN:
        return IntrinsicsOutcome.TOO_LITTLE_SHOWN
    if not (gain.mean() > _GAIN and gain.mean() > _SIGNIFICANT * error):
        return IntrinsicsOutcome.NO_GAIN
    if elsewhere < _GAIN:  # NaN says nothing against it
        return IntrinsicsOutcome.ELSEWHERE_WORSE
    if worse > 0.1:
        return IntrinsicsOutcome.REGIONS_WORSE
    return IntrinsicsOutcome.TOO_UNCERTAIN if expected_px > MOST_EXPECTED else IntrinsicsOutcome.REFINED
