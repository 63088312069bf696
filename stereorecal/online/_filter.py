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
# Factors on `Config.wander` and `Config.heating`: calm, warm, hot; shaken.
_PACES = np.array([(1.0, 0.25), (1.0, 1.0), (1.0, 4.0), (8.0, 1.0), (32.0, 1.0)])
_USUAL = np.log([0.3, 0.5, 0.1, 0.05, 0.05])
_MEMORY = 100.0  # measurements
_FARTHEST = 25.0  # squared standard deviations of one measurement: outliers do not tell the speed


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
    """Mean (m,) and covariance (m, m) of θ, the delay, and the rates of the angles."""

    mean: Float[np.ndarray, "m"]
    covariance: Float[np.ndarray, "m m"]

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """Changes of all parameters of the rig, in the units of people."""
        return self.mean[:_LATE]

    @property
    def of_theta(self) -> Float[np.ndarray, "n n"]:
        """The covariance of those."""
        return self.covariance[:_LATE, :_LATE]

    @property
    def is_finite(self) -> bool:
        """Whether it holds nothing that is no number."""
        return bool(np.isfinite(self.mean).all() and np.isfinite(self.covariance).all())

    @property
    def delay(self) -> float:
        """Of the right shutter, in frames."""
        return float(self.mean[_LATE])

    @property
    def of_delay(self) -> float:
        """Its variance."""
        return float(self.covariance[_LATE, _LATE])

    def later(self, config: Config) -> "FilterEstimate":
        """A frame later: the angles go on at their rates, which are slowly forgotten; everything wanders a little."""
        onwards, lasting = np.eye(len(self.mean)), np.exp(-1.0 / config.lasting)
        onwards[:3, _RATES] = np.eye(3)
        onwards[_RATES, _RATES] = lasting * np.eye(3)
        rates = np.sqrt(1.0 - lasting**2) * np.asarray(config.heating)
        delay = 0.0 if config.synchronous else _DELAY_WANDER
        steps = np.zeros(len(self.mean))
        steps[:SIZE] = [*config.wander, config.shift, config.shift]
        steps[_LATE], steps[_RATES] = delay, rates
        covariance = onwards @ self.covariance @ onwards.T + np.diag(steps**2)
        # Row and column together: an element that is cut alone leaves what is no covariance.
        shrinkage = np.ones(len(self.mean))
        shrinkage[_LATE] = _DELAY / max(_DELAY, float(np.sqrt(covariance[_LATE, _LATE])))
        return FilterEstimate(onwards @ self.mean, covariance * np.outer(shrinkage, shrinkage))

    def updated(self, measured: Measurement) -> "FilterEstimate":
        """With one more measurement; by extrinsics alone, where it says nothing new of lenses (Schmidt 1966)."""
        design, information = measured.design, measured.normal.a
        pull = design.T @ (measured.normal.b - information @ (design @ self.mean))
        # Not the inverse of the covariance: what does not drift at all has none.
        known = np.eye(len(self.mean)) + self.covariance @ design.T @ information @ design
        covariance = np.linalg.solve(known, self.covariance)
        mean, covariance = self.mean + covariance @ pull, 0.5 * (covariance + covariance.T)
        if measured.as_extrinsics is not None:
            lenses = slice(SIZE, _LATE)
            held = np.vstack([-measured.as_extrinsics[:, SIZE:], np.eye(len(mean[lenses]))])
            learnt = (self.covariance - covariance)[lenses, lenses]
            covariance[:_LATE, :_LATE] += held @ learnt @ held.T
            mean[:_LATE] -= held @ (mean - self.mean)[lenses]
        return FilterEstimate(mean, covariance)

    def chance_of(self, measured: Measurement) -> float:
        """Of a measurement as far from the estimate as this one, or farther (chi-square of the innovation)."""
        from scipy.special import chdtrc  # a third of a second to import

        number, squared_distance, _ = self._innovation(measured)
        return float(chdtrc(number, squared_distance)) if number else 1.0

    def log_likelihood(self, measured: Measurement, most: float = np.inf) -> float:
        """Of a measurement, one that is farther away than so many squared standard deviations being as far."""
        _, squared_distance, log_volume = self._innovation(measured)
        return -0.5 * (min(squared_distance, most) + log_volume)

    def _innovation(self, measured: Measurement) -> tuple[int, float, float]:
        """How many numbers are measured, how far they are from the estimate, squared standard deviations, and the
        logarithm of the determinant of the covariance of that. Numbers of what drifts: the pull on them, by what is
        measured, of an estimate that is not there (a score test: Rao 1948); lenses, hardly measured, would hide it."""
        information, design = measured.normal.a, measured.design
        pull = (measured.normal.b - information @ (design @ self.mean))[:SIZE]
        of_look = design @ self.covariance @ design.T + np.diag(self._doubt(measured))
        spread = information[:SIZE, :SIZE] + information[:SIZE] @ of_look @ information[:, :SIZE]
        values, axes = np.linalg.eigh(information[:SIZE, :SIZE])
        some = values > 1e-9 * max(float(values[-1]), 1e-12)
        told = axes[:, some] / np.sqrt(values[some])
        pull, spread = told.T @ pull, told.T @ spread @ told
        return len(pull), float(pull @ np.linalg.solve(spread, pull)), float(np.linalg.slogdet(spread)[1])

    def doubted(self, measured: Measurement) -> Measurement:
        """The measurement, less sure by what the delay makes of an error of the turn."""
        a, b, c = measured.normal.a, measured.normal.b, measured.normal.c
        less = np.linalg.inv(np.eye(len(b)) + a * self._doubt(measured))
        return replace(measured, normal=Normal(less @ a, less @ b, c))

    def _doubt(self, measured: Measurement) -> Float[np.ndarray, "n"]:
        """Variances of what is measured, by an error of the turn."""
        doubt = np.zeros(len(measured.normal.b))
        if measured.turn is not None:
            doubt[:3] = (_TURN_ERROR * self.delay * float(np.linalg.norm(measured.turn))) ** 2
        return doubt

    def followed(self, measured: Measurement, together: int = 1) -> "FilterEstimate":
        """With one more measurement, less sure by the turn's error, of which so many err together: none votes twice."""
        return self.updated(self.doubted(measured).weighed(1.0 / together))

    def late(self) -> "FilterEstimate":
        """After a shutter may have begun to be late, or ceased: the rig turns and travels while it is."""
        widened = self._widened([0.0, 0.0, 0.0, _TRAVEL, _TRAVEL])
        widened.covariance[_LATE, _LATE] += _DELAY**2
        return widened

    def after_knock(self) -> "FilterEstimate":
        """After a knock: as far away as a rig may drift."""
        return self._widened(DRIFT)

    def of_shutters(self, synchronous: bool) -> "FilterEstimate":
        """With a delay of 0, if it is said that the shutters open at once; with any, if it is no more."""
        mean, known = self.mean.copy(), self.covariance.copy()
        mean[_LATE], known[_LATE], known[:, _LATE] = 0.0, 0.0, 0.0
        known[_LATE, _LATE] = 0.0 if synchronous else _DELAY**2
        return FilterEstimate(mean, known)

    def turned(self, yaw: float) -> "FilterEstimate":
        """After a yaw of so many degrees that is not the rig's: of other things that move."""
        return self._widened([0.0, yaw])

    def moved(self, theta: Float[np.ndarray, "k"], covariance: Float[np.ndarray, "k k"]) -> "FilterEstimate":
        """With the first k numbers of θ from elsewhere; what is left depends on them no more."""
        mean, known, k = self.mean.copy(), self.covariance.copy(), len(theta)
        mean[:k], known[:k], known[:, :k] = theta, 0.0, 0.0
        known[:k, :k] = covariance
        return FilterEstimate(mean, known)

    def _widened(self, by: Sequence[float] | Float[np.ndarray, "k"]) -> "FilterEstimate":
        """By standard deviations of the first numbers."""
        variances = np.zeros(len(self.mean))
        variances[: len(by)] = np.square(by)
        return replace(self, covariance=self.covariance + np.diag(variances))


def at_start(of_theta: Float[np.ndarray, "n n"], config: Config) -> FilterEstimate:
    """The rig that was given, and how far it may be off: a covariance of θ."""
    n = len(of_theta)
    covariance = np.zeros((n + 4, n + 4))
    covariance[:n, :n] = of_theta
    covariance[_LATE, _LATE] = 0.0 if config.synchronous else _DELAY**2
    covariance[_RATES, _RATES] = np.diag(np.square(config.heating))
    return FilterEstimate(np.zeros(n + 4), covariance)


@dataclass(frozen=True, eq=False)
class Pace:
    """How fast a rig drifts: filters and their evidence.

    Attributes:
        several: a filter for each pace.
        logs: (k,) logarithms of the evidence of each.
    """

    several: tuple[FilterEstimate, ...]
    logs: Float[np.ndarray, "k"]

    @staticmethod
    def at(estimate: FilterEstimate) -> "Pace":
        """Filters before anything is learnt."""
        return Pace((estimate,) * len(_PACES), _USUAL)

    def again(self, estimate: FilterEstimate) -> "Pace":
        """The filters from another estimate on, with their evidence."""
        return replace(self, several=(estimate,) * len(self.several))

    def config(self, config: Config) -> Config:
        """The configuration with the learnt wander and heating."""
        weights = np.exp(self.logs - np.logaddexp.reduce(self.logs))
        return _scaled_rates(config, np.sqrt(weights @ _PACES**2))

    def later(self, config: Config) -> "Pace":
        """The filters a frame later."""
        each = zip(self.several, _PACES, strict=True)
        return replace(self, several=tuple(one.later(_scaled_rates(config, times)) for one, times in each))

    def updated(self, measured: Measurement) -> "Pace":
        """The filters after one more measurement."""
        logs = np.array([one.log_likelihood(measured, _FARTHEST) for one in self.several])
        logs = _USUAL + (1.0 - 1.0 / _MEMORY) * (self.logs - _USUAL) + logs
        return Pace(tuple(one.followed(measured) for one in self.several), logs - logs.max())


def _scaled_rates(config: Config, times: Float[np.ndarray, "2"]) -> Config:
    wander, heating = (
        tuple((factor * np.asarray(some)).tolist())
        for factor, some in zip(times, (config.wander, config.heating), strict=True)
    )
    return replace(config, wander=wander, heating=heating)
