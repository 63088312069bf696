"""Whether freed intrinsics are taken: judged, like extrinsics, on what took no part."""

import enum
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._plain import plain
from stereorecal.recalibration._acceptance import MOST_WORSE, Reason, at_the_edge, implausible

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
    IMPLAUSIBLE = "the intrinsics stay: others lie too far off for the stated priors; give wider ones if that may be"
    STRETCHED = (
        "the intrinsics stay: images that are stretched would explain the gain as well; check how they were resized"
    )
    TOO_LITTLE_SHOWN = "the intrinsics stay: too little of the view is covered; add scenes with texture up to the edges"
    TOO_UNCERTAIN = "the intrinsics stay: the scenes do not determine them; add scenes at other depths and places"
    NOT_HERE = "the intrinsics were refined with other recordings, but this one does without"
    REFUSED = "the intrinsics stay: the calibration that they belong to was refused"
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
    fixed_elsewhere_px: float
    freed_elsewhere_px: float
    shown: float
    expected_px: float
    refused: Reason | None = None

    @property
    def taken(self) -> bool:
        """True if the calibration to use has them."""
        return self.outcome is IntrinsicsOutcome.REFINED

    def not_here(self, why: Reason) -> "Intrinsics":
        """The same for a recording whose calibration does without, where others took them."""
        return replace(self, outcome=IntrinsicsOutcome.NOT_HERE, refused=why) if self.taken else self

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
                "refused": self.refused and self.refused.name.lower(),
                "parameters": by_name,
                "undetermined": self.undetermined,
                **{name: getattr(self, name) for name in names},
            }
        )

    @property
    def _said(self) -> str:
        return self.outcome.value + (f": {self.refused.value}" if self.refused else "")

    def __str__(self) -> str:
        lines = [
            f"{self._said} ({self.fixed_px:.3f} px as given, {self.freed_px:.3f} px freed)",
            *(
                f"{name:<10} changed by {change:+9.4f} ± {interval:.4f} {unit}".rstrip()
                for name, unit, change, interval in zip(self.names, self.units, self.change, self.interval, strict=True)
                if self.taken
            ),
        ]
        if self.taken and self.undetermined:
            lines.append(f"as uncertain as before: {', '.join(self.undetermined)}")
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Gain:
    """What freed intrinsics gain; pixels of the images in which rows were measured.

    Attributes:
        by_place: (p,) in row error at each place, by solutions that have not seen it.
        elsewhere: gain on recordings or frames that took no part; None where there are none.
        over_stretch: (p,) the same against images that are stretched, and the intrinsics as given: what an image that
            was resized out of shape would explain as well is no sign of another focal length.
        worse: share of the regions that are worse than with the intrinsics as given; where recordings cannot do
            without on their own, of the one that is worst off.
    """

    by_place: Float[np.ndarray, "p"]
    elsewhere: float | None
    over_stretch: Float[np.ndarray, "p"]
    worse: float


def outcome(
    gain: Gain, *, shown: float, expected_px: float, z: Float[np.ndarray, "n"], prior: float
) -> IntrinsicsOutcome:
    """What becomes of freed intrinsics. Nothing that is no number passes.

    Args:
        shown, expected_px: see `Intrinsics`.
        z: of those that priors bound, in the box.
        prior: their standard deviation there.
    """
    if not shown >= LEAST_SHOWN:
        return IntrinsicsOutcome.TOO_LITTLE_SHOWN
    if not _significant(gain.by_place):
        return IntrinsicsOutcome.NO_GAIN
    if gain.elsewhere is not None and not gain.elsewhere >= _GAIN:
        return IntrinsicsOutcome.ELSEWHERE_WORSE
    if not gain.worse <= MOST_WORSE:
        return IntrinsicsOutcome.REGIONS_WORSE
    if at_the_edge(z) or implausible(z, prior):
        return IntrinsicsOutcome.IMPLAUSIBLE
    if not expected_px <= MOST_EXPECTED:
        return IntrinsicsOutcome.TOO_UNCERTAIN
    return IntrinsicsOutcome.REFINED if _significant(gain.over_stretch) else IntrinsicsOutcome.STRETCHED


def _significant(gain: Float[np.ndarray, "p"]) -> bool:
    """Whether a gain at places is worth it, and no chance."""
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
    return bool(gain.mean() > _GAIN and gain.mean() > _SIGNIFICANT * error)
