"""A candidate against the calibration in use, on looks that came after those it was fitted to.

Wald's sequential test of two hypotheses (Wald 1945): the logarithm of their likelihood ratio is summed over looks until
it leaves one of two bounds. One look counts for so much and no more, or a single one that is wrong would decide.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.online._estimate import Measurement

_MOST_OF_ONE = 4.0  # of the logarithm
_LOST = -3.0
_LONGEST = 60  # looks
_FEWEST = 3  # likewise
_ROWS_LOST = 0.02  # pixels, as the acceptance of a repair has it
_BLIND_TOO = 0.5  # of the logarithm: neither sees anything
_MATCHES = 2.0  # times as many correspondences: it sees where the other is blind


@dataclass(frozen=True, eq=False)
class Trial:
    """A candidate on trial.

    Attributes:
        offset: (5,) of the candidate.
        by: what it was fitted by: "looks" or "repair".
        since: the last frame that it was fitted to.
        evidence: the logarithm of the likelihood ratio against the calibration in use.
        looks: that came later.
        rows_before, rows_after: sums over these looks of the row error in use, and of the candidate, pixels.
        compared: looks that both could measure.
    """

    offset: Float[np.ndarray, "5"]
    by: str
    since: int
    evidence: float = 0.0
    looks: int = 0
    rows_before: float = 0.0
    rows_after: float = 0.0
    compared: int = 0

    def measured(self, using: Float[np.ndarray, "5"], seen: Measurement, before: float, after: float) -> "Trial":
        """With a look that both share, and their row errors in it."""

        def misses(offset: Float[np.ndarray, "5"]) -> float:
            miss = seen.offset - offset
            return 0.5 * float(miss @ seen.information @ miss)

        gain = float(np.clip(misses(using) - misses(self.offset), -_MOST_OF_ONE, _MOST_OF_ONE))
        return replace(
            self,
            evidence=self.evidence + gain,
            looks=self.looks + 1,
            rows_before=self.rows_before + before,
            rows_after=self.rows_after + after,
            compared=self.compared + 1,
        )

    def matched(self, before: float, after: float) -> "Trial":
        """With a look in which the one in use is blind: shares of the image in which matches were found."""
        gain = _MOST_OF_ONE if after > _MATCHES * before else -_BLIND_TOO
        return replace(self, evidence=self.evidence + gain, looks=self.looks + 1)

    def won(self, chance: float) -> bool:
        """Whether it is better, at this chance that it is not."""
        lost = self.compared and (self.rows_after - self.rows_before) / self.compared > _ROWS_LOST
        return self.looks >= _FEWEST and self.evidence > -np.log(chance) and not lost

    @property
    def lost(self) -> bool:
        """Whether it is no better, or has had its time."""
        return self.evidence < _LOST or self.looks >= _LONGEST

    def as_dict(self) -> dict[str, float | int | str | None]:
        """The proof, as plain data."""
        mean = 1.0 / self.compared if self.compared else None
        return {
            "by": self.by,
            "fitted_until": self.since,
            "later_looks": self.looks,
            "log_likelihood_ratio": self.evidence,
            "row_error_before_px": mean and mean * self.rows_before,
            "row_error_after_px": mean and mean * self.rows_after,
        }
