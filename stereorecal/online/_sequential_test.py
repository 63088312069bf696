"""A candidate against the calibration in use, on looks that came after those it was fitted to.

Wald's sequential test of two hypotheses (Wald 1945): the logarithm of their likelihood ratio over all looks, until it
leaves one of two bounds. One look counts for so much and no more, or a single one that is wrong would decide. A shutter
may be late throughout a trial, and its delay is integrated out of all looks at once: on a rig that turns evenly it says
the same in each, which is no more proof than once.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from stereorecal.online._filter import POSES, Measurement

_MOST_OF_ONE = 4.0  # of the logarithm
_LOST = -3.0
_LONGEST = 60  # looks
_FEWEST = 3  # likewise
_BLIND_TOO = 0.5  # of the logarithm: neither sees anything
_MATCHES = 2.0  # times as many correspondences: it sees where the other is blind


@dataclass(frozen=True, eq=False)
class SequentialTest:
    """A candidate on trial.

    Attributes:
        offset: (5,) of the candidate.
        by: what it was fitted by: "looks" or "repair".
        since: the last frame that it was fitted to.
        looks: that came later.
        rows_before, rows_after: sums over these looks of the row error in use, and of the candidate, pixels.
        compared: looks that both could measure.
        matches: the logarithm of the likelihood ratio from looks in which the one in use is blind.
        misses: (2,) of the calibration in use and of the candidate: how far off the other looks measure them, squared,
            in standard deviations, summed.
        pulls: (2, 4) towards a delay, a travel along y and z, and a yaw in common that would explain these.
        known: (4, 4) the information that these looks hold on the four.
    """

    offset: Float[np.ndarray, "5"]
    by: str
    since: int
    looks: int = 0
    rows_before: float = 0.0
    rows_after: float = 0.0
    compared: int = 0
    matches: float = 0.0
    misses: Float[np.ndarray, "2"] = field(default_factory=lambda: np.zeros(2))
    pulls: Float[np.ndarray, "2 4"] = field(default_factory=lambda: np.zeros((2, POSES)))
    known: Float[np.ndarray, "4 4"] = field(default_factory=lambda: np.zeros((POSES, POSES)))

    def measured(
        self, using: Float[np.ndarray, "5"], measurement: Measurement, before: float, after: float
    ) -> "SequentialTest":
        """With a look that both share, and their row errors in it."""
        return replace(
            self.moved(using, measurement),
            looks=self.looks + 1,
            rows_before=self.rows_before + before,
            rows_after=self.rows_after + after,
            compared=self.compared + 1,
        )

    def moved(self, using: Float[np.ndarray, "5"], measurement: Measurement) -> "SequentialTest":
        """With what the rig's motion tells, which shows no rows."""
        added = self._with(using, measurement)
        while abs(added.evidence - self.evidence) > _MOST_OF_ONE:
            measurement = measurement.weighed(0.5)
            added = self._with(using, measurement)
        return added

    def _with(self, using: Float[np.ndarray, "5"], measurement: Measurement) -> "SequentialTest":
        off = measurement.offset - np.stack([using, self.offset])
        pulled = measurement.information @ measurement.poses
        return replace(
            self,
            misses=self.misses + np.einsum("hi,ij,hj->h", off, measurement.information, off),
            pulls=self.pulls + off @ pulled,
            known=self.known + measurement.poses.T @ pulled,
        )

    @property
    def evidence(self) -> float:
        """The logarithm of the likelihood ratio against the calibration in use."""
        explained = np.einsum("hp,hp->h", self.pulls, np.linalg.solve(np.eye(POSES) + self.known, self.pulls.T).T)
        using, candidate = (self.misses - explained).tolist()
        return self.matches + 0.5 * (using - candidate)

    def matched(self, before: float, after: float) -> "SequentialTest":
        """With a look in which the one in use is blind: shares of the image in which matches were found."""
        gain = _MOST_OF_ONE if after > _MATCHES * before else -_BLIND_TOO
        return replace(self, matches=self.matches + gain, looks=self.looks + 1)

    def won(self, chance: float) -> bool:
        """Whether it is better, at this chance that it is not."""
        sure = self.looks >= _FEWEST and self.evidence > -np.log(chance)
        return bool(sure and self.rows_after <= self.rows_before)

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
