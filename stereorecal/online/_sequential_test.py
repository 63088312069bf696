"""A candidate against the calibration in use, on looks that came after those it was fitted to.

Wald's sequential test of two hypotheses (Wald 1945): the logarithm of their likelihood ratio over all looks, until it
leaves one of two bounds. One look counts for so much and no more, or a single one that is wrong would decide. What
poses as an offset in all looks alike (a shutter may be late throughout a trial) is integrated out of all of them at
once: on a rig that turns evenly it says the same in each, which is no more proof than once.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Normal, root
from stereorecal.online._filter import DRIFT, LEFT, SIZE, FilterEstimate, Measurement

_MOST_OF_ONE = 4.0  # of the logarithm
_LOST = -3.0
_LONGEST = 60  # looks
_FEWEST = 3  # likewise
_BLIND_TOO = 0.5  # of the logarithm: neither sees anything
_MATCHES = 2.0  # times as many correspondences: it sees where the other is blind
_LATE = 0.3  # frames: a delay that is thought possible before one is named
_TRAVEL = 3.0  # percent of the baseline: by what the rig may travel during a delay


@dataclass(frozen=True, eq=False)
class SequentialTest:
    """A candidate on trial.

    Attributes:
        offset: (5,) of the candidate.
        using: (5,) of the calibration in use.
        by: what it was fitted by: "looks" or "repair".
        since: the last frame that it was fitted to.
        left: (n,) what the candidate leaves of θ, as it was known by then: it cannot correct lenses.
        poses: (n + 1, q) what poses as an offset in all looks alike, in θ and the delay, a standard deviation each: a
            late shutter, the rig's travel along y and z, and what is not known of `left` whatever the offset is.
        shown: the likelihood of θ and the delay by the looks that came later.
        looks: how many.
        rows_before, rows_after: sums over these looks of the row error in use, and of the candidate, pixels.
        compared: looks that both could measure.
        matches: the logarithm of the likelihood ratio from looks in which the one in use is blind.
    """

    offset: Float[np.ndarray, "5"]
    using: Float[np.ndarray, "5"]
    by: str
    since: int
    left: Float[np.ndarray, "n"]
    poses: Float[np.ndarray, "p q"]
    shown: Normal
    looks: int = 0
    rows_before: float = 0.0
    rows_after: float = 0.0
    compared: int = 0
    matches: float = 0.0

    def measured(self, measurement: Measurement, before: float, after: float) -> "SequentialTest":
        """With a look that both share, and their row errors in it."""
        return replace(
            self.moved(measurement),
            looks=self.looks + 1,
            rows_before=self.rows_before + before,
            rows_after=self.rows_after + after,
            compared=self.compared + 1,
        )

    def moved(self, measurement: Measurement) -> "SequentialTest":
        """With what the rig's motion tells, which shows no rows."""
        added = self._with(measurement)
        while abs(added.evidence - self.evidence) > _MOST_OF_ONE:
            measurement = measurement.weighed(0.5)
            added = self._with(measurement)
        return added

    def _with(self, measurement: Measurement) -> "SequentialTest":
        to = np.column_stack([np.eye(len(self.left)), measurement.way])
        a, b, c = measurement.normal.a, measurement.normal.b, measurement.normal.c
        return replace(self, shown=self.shown + Normal(to.T @ a @ to, to.T @ b, c))

    @cached_property
    def evidence(self) -> float:
        """The logarithm of the likelihood ratio against the calibration in use."""
        using, candidate = map(self._distance, (self.using, self.offset))
        return self.matches + 0.5 * (using - candidate)

    def _distance(self, offset: Float[np.ndarray, "5"]) -> float:
        """Squared, of an offset from what these looks show, the rest being as near as it may."""
        theta = np.append(self.left, 0.0)
        theta[:SIZE] += offset
        away, poses = self.shown.around(theta), self.poses
        pull = poses.T @ away.b
        return away.c - float(pull @ np.linalg.solve(np.eye(len(pull)) + poses.T @ away.a @ poses, pull))

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


def trial(
    offset: Float[np.ndarray, "5"],
    using: Float[np.ndarray, "5"],
    by: str,
    since: int,
    known: FilterEstimate,
    *,
    synchronous: bool,
) -> SequentialTest:
    """A candidate on trial, by what is known of the rest when it is put up.

    Args:
        synchronous: whether the shutters are known to open at once.
    """
    left, follows = known.theta, known.covariance[LEFT, DRIFT]
    left[:SIZE] -= offset
    whatever = known.covariance[LEFT, LEFT] - follows @ np.linalg.pinv(known.of_offset, hermitian=True) @ follows.T
    n = len(left)
    poses = np.zeros((n + 1, n + 3))
    poses[:n, :n] = root(whatever)
    if not synchronous:
        poses[n, n] = _LATE
        poses[3, n + 1] = poses[4, n + 2] = _TRAVEL
    return SequentialTest(offset, using, by, since, left, poses, Normal(np.zeros((n + 1, n + 1)), np.zeros(n + 1), 0.0))
