"""A recursive estimate of the true rig, and of how late a shutter is.

A Kalman filter in its information form (Anderson & Moore 1979, chapter 6), over θ, the changes of all parameters of the
rig from the one that was given first; the delay of the right shutter in frames; and the rates at which the angles
drift, in degrees a frame. What a look at rows or a window of the rig's motion says is a normal likelihood of θ, as an
estimate of recordings has it; a look sees θ plus the delay times the rig's own turn between frames. The extrinsics
walk, the lenses stay as the calibration left them.

Heat drifts one way for minutes. A rate that is forgotten slowly (a process of Ornstein and Uhlenbeck) follows it; a
random walk alone would lag behind, and not know it.

The speed at which a rig drifts is learnt while it drives. Multiple-model estimation (Magill 1965): several filters
differ only in how far the angles may move from one pair to the next. A filter whose predictions fit the measurements
gets more weight. Old measurements are forgotten.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Normal
from stereorecal.objectives import EXTRINSICS
from stereorecal.online._config import Config

SIZE = len(EXTRINSICS)  # what drifts: the first of θ
DRIFT = np.ones(SIZE)  # degrees and percent of the baseline: standard deviations of a drift that is thought possible
_DELAY = 0.5  # frames: standard deviation before anything is known
_TRAVEL = 3.0  # percent of the baseline: by what the rig may travel during a delay
_DELAY_WANDER = 5e-3  # a frame, likewise
_TURN_ERROR = 0.1  # of the rig's turn: what is near seems to turn when the rig travels
_LATE, _RATES = -4, slice(-3, None)  # after θ
_LASTING = np.exp(-1.0 / 250.0)  # a frame: rates last for 250
# Factors on `Config.wander` and `Config.heating`: calm, warm, hot; shaken.
PACES = np.array([(1.0, 0.25), (1.0, 1.0), (1.0, 4.0), (8.0, 1.0), (32.0, 1.0)])
USUAL = np.log([0.3, 0.5, 0.1, 0.05, 0.05])
_AS_SET = np.ones(2)
_MEMORY = 100.0  # measurements
_FARTHEST = 25.0  # squared standard deviations of one measurement: outliers do not tell the speed

OfEach = Float[np.ndarray, "*k"] | float


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a look or a window says of the rig.

    Attributes:
        normal: the likelihood of θ (n,).
        turn: (3,) by which a delay of one frame would turn the right camera, degrees; None if that is not known.
        as_extrinsics: (5, n) of what it says nothing new of lenses, but once more what those before said: the change of
            extrinsics that stands for one of θ; else None.
    """

    normal: Normal
    turn: Float[np.ndarray, "3"] | None
    as_extrinsics: Float[np.ndarray, "5 n"] | None = None

    @property
    def design(self) -> Float[np.ndarray, "n m"]:
        """What is measured of an estimate: θ, and what the delay makes of the turn."""
        n = len(self.normal.b)
        design = np.eye(n, n + 4)
        design[:3, _LATE] = 0.0 if self.turn is None else self.turn
        return design

    def weighed(self, share: float) -> "Measurement":
        """The same with a share of its information."""
        a, b, c = self.normal.a, self.normal.b, self.normal.c
        return replace(self, normal=Normal(share * a, share * b, share * c))


@dataclass(frozen=True, eq=False)
class FilterEstimate:
    """Mean (*k, m) and covariance (*k, m, m) of θ, the delay, and the rates of the angles; of several filters, too."""

    mean: Float[np.ndarray, "*k m"]
    covariance: Float[np.ndarray, "*k m m"]

    def __getitem__(self, number: int | slice) -> "FilterEstimate":
        """One of several filters, or some."""
        return FilterEstimate(self.mean[number], self.covariance[number])

    @property
    def theta(self) -> Float[np.ndarray, "*k n"]:
        """Changes of all parameters of the rig, in the units of people."""
        return self.mean[..., :_LATE]

    @property
    def of_theta(self) -> Float[np.ndarray, "*k n n"]:
        """The covariance of those."""
        return self.covariance[..., :_LATE, :_LATE]

    @property
    def delay(self) -> float:
        """How late the right shutter is, in frames."""
        return float(self.mean[_LATE])

    @property
    def of_delay(self) -> float:
        """Its variance."""
        return float(self.covariance[_LATE, _LATE])

    def later(self, config: Config, paces: Float[np.ndarray, "*k 2"] = _AS_SET) -> "FilterEstimate":
        """A frame later: the angles go on at their rates, which are slowly forgotten; everything wanders a little.

        Args:
            paces: factors on `config.wander` and `config.heating`.
        """
        onwards = np.eye(self.mean.shape[-1])
        onwards[:3, _RATES] = np.eye(3)
        onwards[_RATES, _RATES] = _LASTING * np.eye(3)
        steps, shrinkage = np.zeros(self.mean.shape), np.ones(self.mean.shape)
        steps[..., :3], steps[..., 3:SIZE] = paces[..., :1] * config.wander, config.shift
        steps[..., _LATE] = 0.0 if config.synchronous else _DELAY_WANDER
        steps[..., _RATES] = np.sqrt(1.0 - _LASTING**2) * paces[..., 1:] * config.heating
        covariance = onwards @ self.covariance @ onwards.T + steps[..., None] ** 2 * np.eye(len(onwards))
        # Row and column together: an element that is cut alone leaves what is no covariance.
        shrinkage[..., _LATE] = _DELAY / np.maximum(_DELAY, np.sqrt(covariance[..., _LATE, _LATE]))
        return FilterEstimate(self.mean @ onwards.T, covariance * shrinkage[..., None] * shrinkage[..., None, :])

    def updated(self, measured: Measurement, together: float | Float[np.ndarray, "*k"] = 1.0) -> "FilterEstimate":
        """The estimate with one more measurement, of which so many err together: none votes twice; by extrinsics alone,
        where it says nothing new of lenses (Schmidt 1966)."""
        design, share = measured.design, 1.0 / np.asarray(together)[..., None]
        information, told = self._undoubted(measured)
        information = design.T @ (share[..., None] * information) @ design
        pull = (share * told) @ design - (information @ self.mean[..., None])[..., 0]
        # Not the inverse of the covariance: what does not drift at all has none.
        covariance = np.linalg.solve(np.eye(len(design.T)) + self.covariance @ information, self.covariance)
        mean = self.mean + (covariance @ pull[..., None])[..., 0]
        covariance = 0.5 * (covariance + covariance.swapaxes(-1, -2))
        if measured.as_extrinsics is not None:
            lenses = slice(SIZE, _LATE)
            held = np.vstack([-measured.as_extrinsics[:, SIZE:], np.eye(len(design) - SIZE)])
            learnt = (self.covariance - covariance)[..., lenses, lenses]
            covariance[..., :_LATE, :_LATE] += held @ learnt @ held.T
            mean[..., :_LATE] -= (mean - self.mean)[..., lenses] @ held.T
        return FilterEstimate(mean, covariance)

    def _undoubted(self, measured: Measurement) -> tuple[Float[np.ndarray, "*k n n"], Float[np.ndarray, "*k n"]]:
        """What a measurement tells of what it measures, less what the delay makes of an error of the turn."""
        a, b, doubt = measured.normal.a, measured.normal.b, self._doubt(measured)
        less = doubt * np.linalg.solve(np.eye(3) + doubt * a[:3, :3], a[:3])
        return a - a[:, :3] @ less, b - b[:3] @ less

    def chance_of(self, measured: Measurement) -> float:
        """The probability that a measurement is as far from the estimate, or farther (chi-square of the innovation)."""
        from scipy.special import chdtrc  # a third of a second to import

        number, squared_distance, _ = self._innovation(measured)
        return float(chdtrc(number, squared_distance)) if number else 1.0

    def log_likelihood(self, measured: Measurement, most: float = np.inf) -> OfEach:
        """The logarithm of the likelihood; farther away than `most`, in squared standard deviations, a measurement
        counts as being that far."""
        _, squared_distance, log_volume = self._innovation(measured)
        return -0.5 * (np.minimum(squared_distance, most) + log_volume)

    def _innovation(self, measured: Measurement) -> tuple[int, OfEach, OfEach]:
        """How many numbers are measured, how far they are from the estimate, squared standard deviations, and the
        logarithm of the determinant of the covariance of that. Numbers of what drifts: the pull on them, by what is
        measured, of an estimate that is not there (a score test: Rao 1948); lenses, hardly measured, would hide it."""
        information, design = measured.normal.a, measured.design
        seen, drifts = information[:SIZE] @ design, information[:3, :SIZE]
        doubt = self._doubt(measured) * (drifts.T @ drifts)
        spread = information[:SIZE, :SIZE] + seen @ self.covariance @ seen.T + doubt
        values, axes = np.linalg.eigh(information[:SIZE, :SIZE])
        some = values > 1e-9 * max(float(values[-1]), 1e-12)
        told = axes[:, some] / np.sqrt(values[some])
        pull, spread = (measured.normal.b[:SIZE] - self.mean @ seen.T) @ told, told.T @ spread @ told
        squared_distance = np.sum(pull * np.linalg.solve(spread, pull[..., None])[..., 0], axis=-1)
        return pull.shape[-1], squared_distance, np.linalg.slogdet(spread)[1]

    def _doubt(self, measured: Measurement) -> Float[np.ndarray, "*k 1 1"]:
        """Variance of what is measured of each angle, by an error of the turn."""
        turn = 0.0 if measured.turn is None else float(np.linalg.norm(measured.turn))
        return np.square(_TURN_ERROR * turn * self.mean[..., _LATE])[..., None, None]

    def late(self) -> "FilterEstimate":
        """The estimate after a shutter may have begun to be late, or ceased: the rig turns and travels while it is."""
        late = self.widened([0.0, 0.0, 0.0, _TRAVEL, _TRAVEL])
        late.covariance[_LATE, _LATE] += _DELAY**2
        return late

    def widened(self, by: Sequence[float] | Float[np.ndarray, "k"]) -> "FilterEstimate":
        """The estimate with so large a further error of the first numbers, in standard deviations."""
        variances = np.zeros(self.mean.shape[-1])
        variances[: len(by)] = np.square(by)
        return FilterEstimate(self.mean, self.covariance + np.diag(variances))

    def moved(
        self, numbers: Float[np.ndarray, "k"], covariance: Float[np.ndarray, "k k"], first: int = 0
    ) -> "FilterEstimate":
        """The estimate with k numbers from elsewhere, from the first of θ on; what is left depends on them no more."""
        mean, known = self.mean.copy(), self.covariance.copy()
        some = slice(first, first + len(numbers))
        mean[some], known[some], known[:, some] = numbers, 0.0, 0.0
        known[some, some] = covariance
        return FilterEstimate(mean, known)

    def of_shutters(self, synchronous: bool) -> "FilterEstimate":
        """The estimate with a delay of 0, if it is said that the shutters open at once; with any, if it is no more."""
        variance = 0.0 if synchronous else _DELAY**2
        return self.moved(np.zeros(1), np.array([[variance]]), len(self.mean) + _LATE)


def at_start(of_theta: Float[np.ndarray, "n n"], config: Config) -> FilterEstimate:
    """The rig that was given, and how far it may be off: a covariance of θ."""
    n = len(of_theta)
    nothing = FilterEstimate(np.zeros(n + 4), np.zeros((n + 4, n + 4)))
    rates = nothing.moved(np.zeros(3), np.diag(np.square(config.heating)), n + 1)
    return rates.moved(np.zeros(n), of_theta).of_shutters(config.synchronous)


def filters_beside(freed: FilterEstimate, estimate: FilterEstimate) -> FilterEstimate:
    """What is followed beside an estimate: another one, and one for each of PACES."""
    each = [freed, *[estimate] * len(PACES)]
    return FilterEstimate(np.stack([one.mean for one in each]), np.stack([one.covariance for one in each]))


def learnt_logs(logs: Float[np.ndarray, "k"], filters: FilterEstimate, measured: Measurement) -> Float[np.ndarray, "k"]:
    """The evidence of the filters of all paces after one more measurement; what is old is forgotten."""
    logs = USUAL + (1.0 - 1.0 / _MEMORY) * (logs - USUAL) + filters.log_likelihood(measured, _FARTHEST)
    return logs - logs.max()
