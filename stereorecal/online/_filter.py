"""A recursive estimate of where the true rig stands, and by how much a shutter is late.

A Kalman filter in its information form (Anderson & Moore 1979, chapter 6), over eleven numbers: the offset of the true
rig from the one that was given first (pitch, yaw, roll in degrees, y, z in percent of the baseline), the delay of the
right shutter in frames, the rates at which the angles drift, in degrees a frame, and the keystone: the yaw that rows
show beyond the one that depth shows, since the intrinsics are not what the calibration says; and what the same lenses
leave of the yaw that the rig's motion tells, in all windows alike, which are no surer of it for being many. What one
look measures is the offset plus the delay times the rig's own turn between frames, and the keystone besides; what the
rig's motion tells is the offset, and what the lenses leave besides. The offset walks; what is of lenses is constant.

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

from stereorecal.estimation import is_exact
from stereorecal.online._config import Config

SIZE = 5
_DELAY = 0.5  # frames: standard deviation before anything is known
_TRAVEL = 3.0  # percent of the baseline: by what the rig may travel during a delay
_DELAY_WANDER = 5e-3  # a frame, likewise
_TURN_ERROR = 0.1  # of the rig's turn: what is near seems to turn when the rig travels
_RATES = slice(SIZE + 1, SIZE + 4)
KEYSTONE = SIZE + 4
_OF_LENSES = 0.02  # degrees: a yaw that the lenses of a calibrated rig leave in what its motion tells
_YAW = np.eye(SIZE)[1]
# Factors on `Config.wander` and `Config.heating`: calm, warm, hot; shaken.
_PACES = np.array([(1.0, 0.25), (1.0, 1.0), (1.0, 4.0), (8.0, 1.0), (32.0, 1.0)])
_USUAL = np.log([0.3, 0.5, 0.1, 0.05, 0.05])
_MEMORY = 100.0  # measurements
_FARTHEST = 25.0  # squared standard deviations of one measurement: outliers do not tell the speed


@dataclass(frozen=True, eq=False)
class Measurement:
    """What one look says of the offset, in directions that do not depend on each other.

    Attributes:
        offset: (5,) measured.
        information: (5, 5) inverse covariance; singular where the look says nothing.
        turn: (5,) by which a delay of one frame would move it.
        keystone: whether it is measured by rows, which what the calibration left bends like a yaw; else by the rig's
            motion, of which it leaves something as well.
    """

    offset: Float[np.ndarray, "5"]
    information: Float[np.ndarray, "5 5"]
    turn: Float[np.ndarray, "5"]
    keystone: bool = True

    @property
    def design(self) -> Float[np.ndarray, "5 11"]:
        """What is measured of an estimate."""
        of_lenses = np.outer(_YAW, [self.keystone, not self.keystone])
        return np.column_stack([np.eye(SIZE), self.turn, np.zeros((SIZE, 3)), of_lenses])

    def weighed(self, share: float) -> "Measurement":
        """The same with a share of its information."""
        return replace(self, information=share * self.information)


@dataclass(frozen=True, eq=False)
class FilterEstimate:
    """Mean (11,) and covariance (11, 11): the offset, the delay, the rates of the angles, the keystone, and what the
    lenses leave of the yaw that motion tells."""

    mean: Float[np.ndarray, "11"]
    covariance: Float[np.ndarray, "11 11"]

    @property
    def offset(self) -> Float[np.ndarray, "5"]:
        """Of the true rig, degrees and percent."""
        return self.mean[:SIZE]

    @property
    def of_offset(self) -> Float[np.ndarray, "5 5"]:
        """The covariance of the offset."""
        return self.covariance[:SIZE, :SIZE]

    @property
    def is_finite(self) -> bool:
        """Whether it holds nothing that is no number."""
        return bool(np.isfinite(self.mean).all() and np.isfinite(self.covariance).all())

    @property
    def delay(self) -> float:
        """Of the right shutter, in frames."""
        return float(self.mean[SIZE])

    @property
    def keystone(self) -> float:
        """The yaw that rows show beyond that of depth, degrees."""
        return float(self.mean[KEYSTONE])

    def later(self, config: Config) -> "FilterEstimate":
        """A frame later: the angles go on at their rates, which are slowly forgotten; everything wanders a little."""
        onwards, lasting = np.eye(len(self.mean)), np.exp(-1.0 / config.lasting)
        onwards[:3, _RATES] = np.eye(3)
        onwards[_RATES, _RATES] = lasting * np.eye(3)
        rates = np.sqrt(1.0 - lasting**2) * np.asarray(config.heating)
        delay = 0.0 if config.synchronous else _DELAY_WANDER
        steps = np.array([*config.wander, config.shift, config.shift, delay, *rates, 0.0, 0.0]) ** 2
        covariance = onwards @ self.covariance @ onwards.T + np.diag(steps)
        # Row and column together: an element that is cut alone leaves what is no covariance.
        shrinkage = np.ones(len(self.mean))
        shrinkage[SIZE] = _DELAY / max(_DELAY, float(np.sqrt(covariance[SIZE, SIZE])))
        return FilterEstimate(onwards @ self.mean, covariance * np.outer(shrinkage, shrinkage))

    def updated(self, measured: Measurement) -> "FilterEstimate":
        """With one more measurement."""
        design, information = measured.design, measured.information
        pull = design.T @ information @ (measured.offset - design @ self.mean)
        # Not the inverse of the covariance: what does not drift at all has none.
        known = np.eye(len(self.mean)) + self.covariance @ design.T @ information @ design
        covariance = np.linalg.solve(known, self.covariance)
        return FilterEstimate(self.mean + covariance @ pull, 0.5 * (covariance + covariance.T))

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
        logarithm of the determinant of the covariance of that."""
        measured = self.doubted(measured)
        values, axes = np.linalg.eigh(measured.information)
        measured_axes = values > 1e-9 * max(float(values[-1]), 1e-12)
        design = axes[:, measured_axes].T @ measured.design
        innovation = axes[:, measured_axes].T @ measured.offset - design @ self.mean
        spread = design @ self.covariance @ design.T + np.diag(1.0 / values[measured_axes])
        squared_distance = float(innovation @ np.linalg.solve(spread, innovation))
        return int(measured_axes.sum()), squared_distance, float(np.linalg.slogdet(spread)[1])

    def doubted(self, measured: Measurement) -> Measurement:
        """The measurement, less sure by what the delay makes of an error of the turn."""
        turn = _TURN_ERROR * self.delay * float(np.linalg.norm(measured.turn))
        doubt = np.diag([turn**2] * 3 + [0.0, 0.0])
        return replace(
            measured, information=measured.information @ np.linalg.inv(np.eye(SIZE) + doubt @ measured.information)
        )

    def followed(self, measured: Measurement, together: int = 1) -> "FilterEstimate":
        """With one more measurement, less sure by the turn's error, of which so many err together: none votes twice."""
        return self.updated(self.doubted(measured).weighed(1.0 / together))

    def late(self) -> "FilterEstimate":
        """After a shutter may have begun to be late, or ceased: the rig turns and travels while it is."""
        return self._widened([0.0, 0.0, 0.0, _TRAVEL, _TRAVEL, _DELAY])

    def after_knock(self, prior: Float[np.ndarray, "5"]) -> "FilterEstimate":
        """After a knock: as far away as the prior says."""
        return self._widened(prior)

    def of_shutters(self, synchronous: bool) -> "FilterEstimate":
        """With a delay of 0, if it is said that the shutters open at once; with any, if it is no more."""
        mean, known = self.mean.copy(), self.covariance.copy()
        mean[SIZE], known[SIZE], known[:, SIZE] = 0.0, 0.0, 0.0
        known[SIZE, SIZE] = 0.0 if synchronous else _DELAY**2
        return FilterEstimate(mean, known)

    def turned(self, yaw: float) -> "FilterEstimate":
        """After a yaw of so many degrees that is not the rig's: of other things that move."""
        return self._widened([0.0, yaw])

    def with_yaw_of_others(self, yaw: float) -> "FilterEstimate":
        """After rows may have taken a yaw of so many degrees for the keystone: what they know of the sum stays."""
        both = np.zeros(len(self.mean))
        both[1], both[KEYSTONE] = yaw, -yaw
        return replace(self, covariance=self.covariance + np.outer(both, both))

    def moved(self, offset: Float[np.ndarray, "5"], covariance: Float[np.ndarray, "5 5"]) -> "FilterEstimate":
        """With an offset from elsewhere; delay and rates stay, and depend on it no more."""
        return self._replaced(list(range(SIZE)), offset, covariance)

    def told(self, numbers: Float[np.ndarray, "6"], covariance: Float[np.ndarray, "6 6"]) -> "FilterEstimate":
        """The same with the keystone as well, after the offset."""
        return self._replaced([*range(SIZE), KEYSTONE], numbers, covariance)

    def _replaced(
        self, which: list[int], numbers: Float[np.ndarray, "k"], covariance: Float[np.ndarray, "k k"]
    ) -> "FilterEstimate":
        mean, known = self.mean.copy(), self.covariance.copy()
        mean[which] = numbers
        known[which], known[:, which] = 0.0, 0.0
        known[np.ix_(which, which)] = covariance
        return FilterEstimate(mean, known)

    def _widened(self, by: Sequence[float] | Float[np.ndarray, "n"]) -> "FilterEstimate":
        """By standard deviations of the first numbers."""
        variances = np.zeros(len(self.mean))
        variances[: len(by)] = np.square(by)
        return replace(self, covariance=self.covariance + np.diag(variances))


def at_start(prior: Float[np.ndarray, "5"], config: Config, keystone: float = 0.0) -> FilterEstimate:
    """The rig that was given, and how far it may be off, standard deviations; of the keystone, degrees."""
    delay = 0.0 if config.synchronous else _DELAY
    lenses = 0.0 if is_exact(config.prior) else _OF_LENSES
    spread = np.array([*prior, delay, *config.heating, keystone, lenses])
    return FilterEstimate(np.zeros(len(spread)), np.diag(spread**2))


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
