"""What is known of a rig and of its shutters: one normal distribution, which time widens and measurements narrow.

The model is that of the estimate: the true rig is θ = c + d, c what the calibration left (of all parameters of both
cameras), d how far the extrinsics have drifted since. c stays as it is; d walks, and drifts one way for a while, as
heat does: a rate that is slowly forgotten (a process of Ornstein and Uhlenbeck) follows that, where a random walk alone
would lag behind, and not know it. A pair of which the right shutter is late by τ frames shows θ + τ w, w being the way
by which the rig's own motion seems to move the right camera in a frame.

What a look at a pair or a window of the rig's motion says is a `Normal` of that θ (Anderson & Moore 1979, chapter 6: a
Kalman filter in its information form).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import CalibrationPrior, Normal, as_prior
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._config import Config

SIZE = len(EXTRINSICS)
DRIFT, DELAY, RATES, LEFT = slice(0, SIZE), SIZE, slice(SIZE + 1, SIZE + 4), slice(SIZE + 4, None)
KNOCKED = 1.0  # degrees and percent of the baseline: how far a knock, or a drift before the start, moves a rig
# Degrees of yaw that a calibrated rig has turned before the start: where rows show more, it is put down to the
# calibration until motion says otherwise.
_TURNED = 0.02
_DELAY = 0.5  # frames: standard deviation before anything is known
_TRAVEL = 3.0  # percent of the baseline: by what the rig may travel during a delay
_DELAY_WANDER = 5e-3  # a frame, likewise
_TURN_ERROR = 0.1  # of the rig's turn: what is near seems to turn when the rig travels
_CLEARLY = 1.0  # of the logarithm of the evidence
_NOT_MEASURED = 1e-9  # of the largest eigenvalue, in units of what each number is known by


@dataclass(frozen=True, eq=False)
class Measurement:
    """What one look or one window says.

    Attributes:
        frame: number of the pair.
        normal: the likelihood of θ, changes of the rig that was given first; 1 where it is largest (c such that the
            squared distance is 0 there).
        way: (n,) θ by which a delay of one frame seems to move the rig; 0 of shutters that open at once.
    """

    frame: int
    normal: Normal
    way: Float[np.ndarray, "n"]

    @classmethod
    def of(cls, frame: int, normal: Normal, way: Float[np.ndarray, "n"]) -> "Measurement":
        """That of any likelihood of θ."""
        values, axes = _principal(normal.a)
        return cls(frame, replace(normal, c=float((axes @ normal.b) ** 2 @ (1.0 / values))), way)

    def weighed(self, share: float) -> "Measurement":
        """The same with a share of its information."""
        normal = Normal(share * self.normal.a, share * self.normal.b, share * self.normal.c)
        return replace(self, normal=normal)

    def blurred(self, columns: Float[np.ndarray, "n q"]) -> "Measurement":
        """The same where θ is off by these columns, each times a standard normal number of its own."""
        a, b, c = self.normal.a, self.normal.b, self.normal.c
        of_columns, pull = a @ columns, columns.T @ b
        gain = np.linalg.solve(np.eye(columns.shape[1]) + columns.T @ of_columns, np.column_stack([of_columns.T, pull]))
        normal = Normal(a - of_columns @ gain[:, :-1], b - of_columns @ gain[:, -1], c - float(pull @ gain[:, -1]))
        return replace(self, normal=normal)

    @property
    def design(self) -> Float[np.ndarray, "n m"]:
        """θ with the delay, by the numbers of an estimate."""
        n = len(self.way)
        return np.column_stack([np.eye(n, SIZE), self.way, np.zeros((n, 3)), np.eye(n)])


@dataclass(frozen=True, eq=False)
class FilterEstimate:
    """Mean (m,) and covariance (m, m) of the drift [degrees, percent of the baseline], the delay of the right shutter
    [frames], the rates of the angles [degrees a frame], and what the calibration left of θ (n,), in its units."""

    mean: Float[np.ndarray, "m"]
    covariance: Float[np.ndarray, "m m"]

    @property
    def offset(self) -> Float[np.ndarray, "5"]:
        """The drift."""
        return self.mean[DRIFT]

    @property
    def of_offset(self) -> Float[np.ndarray, "5 5"]:
        """Its covariance."""
        return self.covariance[DRIFT, DRIFT]

    @property
    def is_finite(self) -> bool:
        """Whether it holds nothing that is no number."""
        return bool(np.isfinite(self.mean).all() and np.isfinite(self.covariance).all())

    @property
    def delay(self) -> float:
        """Of the right shutter, in frames."""
        return float(self.mean[DELAY])

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """The mean of θ."""
        return self._of_theta @ self.mean

    @property
    def of_theta(self) -> Float[np.ndarray, "n n"]:
        """The covariance of θ."""
        return self._of_theta @ self.covariance @ self._of_theta.T

    @property
    def _of_theta(self) -> Float[np.ndarray, "n m"]:
        n = len(self.mean) - LEFT.start
        return Measurement(0, Normal(np.zeros((n, n)), np.zeros(n), 0.0), np.zeros(n)).design

    def later(self, config: Config) -> "FilterEstimate":
        """A frame later: the angles go on at their rates, which are slowly forgotten; everything but what the
        calibration left wanders a little."""
        onwards, lasting = np.eye(len(self.mean)), np.exp(-1.0 / config.lasting)
        onwards[:3, RATES] = np.eye(3)
        onwards[RATES, RATES] = lasting * np.eye(3)
        steps = np.zeros(len(self.mean))
        steps[DRIFT] = [*config.wander, config.shift, config.shift]
        steps[DELAY] = 0.0 if config.synchronous else _DELAY_WANDER
        steps[RATES] = np.sqrt(1.0 - lasting**2) * np.asarray(config.heating)
        covariance = onwards @ self.covariance @ onwards.T + np.diag(steps**2)
        # Row and column together: an element that is cut alone leaves what is no covariance.
        shrinkage = np.ones(len(self.mean))
        shrinkage[DELAY] = _DELAY / max(_DELAY, float(np.sqrt(covariance[DELAY, DELAY])))
        return FilterEstimate(onwards @ self.mean, covariance * np.outer(shrinkage, shrinkage))

    def updated(self, measured: Measurement) -> "FilterEstimate":
        """With one more measurement."""
        _, pull, after, _ = self._against(measured)
        return FilterEstimate(self.mean + after @ pull, after)

    def chance_of(self, measured: Measurement) -> float:
        """Of a measurement that asks for as large a move of the extrinsics as this one, or a larger one, though they
        have not moved (chi-square)."""
        from scipy.special import chdtrc  # a third of a second to import

        information, pull, after, _ = self._against(self.doubted(measured))
        # As much as the measurement and the estimate leave of a move, all else being as uncertain as it is.
        known = (information - information @ after @ information)[DRIFT, DRIFT]
        values, axes = _principal(known)
        move = axes @ (pull - information @ after @ pull)[DRIFT]
        return float(chdtrc(len(values), move**2 @ (1.0 / values))) if len(values) else 1.0

    def log_likelihood(self, measured: Measurement, most: float = np.inf) -> float:
        """Of a measurement, one that is farther away than so many squared standard deviations being as far."""
        measured = self.doubted(measured)
        _, pull, after, log_volume = self._against(measured)
        at = measured.design @ self.mean
        distance = measured.normal.c - at @ (2.0 * measured.normal.b - measured.normal.a @ at) - pull @ after @ pull
        return -0.5 * (min(float(distance), most) + log_volume)

    def _against(
        self, measured: Measurement
    ) -> tuple[Float[np.ndarray, "m m"], Float[np.ndarray, "m"], Float[np.ndarray, "m m"], float]:
        """The information of a measurement on all numbers, its pull on their mean, their covariance with it, and the
        logarithm of the determinant by which it narrows them."""
        design = measured.design
        information = design.T @ measured.normal.a @ design
        after, log_volume = _narrowed(self.covariance, information)
        return information, design.T @ measured.normal.b - information @ self.mean, after, log_volume

    def doubted(self, measured: Measurement) -> Measurement:
        """The measurement, less sure by what the delay makes of an error of the turn."""
        size = _TURN_ERROR * abs(self.delay) * float(np.linalg.norm(measured.way[:3]))
        return measured.blurred(size * np.eye(len(measured.way), 3)) if size else measured

    def late(self) -> "FilterEstimate":
        """After a shutter may have begun to be late, or ceased: the rig turns and travels while it is."""
        return self._widened(np.array([0.0, 0.0, 0.0, _TRAVEL, _TRAVEL, _DELAY]))

    def after_knock(self) -> "FilterEstimate":
        """After a knock, which may have moved the extrinsics far."""
        return self._widened(np.full(SIZE, KNOCKED))

    def turned(self, yaw: float) -> "FilterEstimate":
        """After a yaw of so many degrees."""
        return self._widened(np.array([0.0, yaw]))

    def turned_before(self) -> "FilterEstimate":
        """As if it had been known at the start that the yaw may have been off by then, and rows had not been put down
        to the calibration alone: the prior of the drift of yaw exchanged for a wide one."""
        variance, follows = float(self.covariance[1, 1]), self.covariance[1]
        prior = max(_TURNED**2, 1.01 * variance)  # it has walked since
        exchanged = 1.0 / prior - 1.0 / (prior + KNOCKED**2)
        gain = exchanged / (1.0 - exchanged * variance)
        covariance = self.covariance + gain * np.outer(follows, follows)
        return FilterEstimate(self.mean + gain * self.mean[1] * follows, covariance)

    def with_prior(self, more: Float[np.ndarray, "n n"]) -> "FilterEstimate":
        """As if more, or less, had been known from the start of what the calibration left, whose prior has mean 0."""
        information = np.zeros_like(self.covariance)
        information[LEFT, LEFT] = more
        after, _ = _narrowed(self.covariance, information)
        return FilterEstimate(self.mean - after @ information @ self.mean, after)

    def of_shutters(self, synchronous: bool) -> "FilterEstimate":
        """With a delay of 0, if it is said that the shutters open at once; with any, if it is no more."""
        mean, known = self.mean.copy(), self.covariance.copy()
        mean[DELAY], known[DELAY], known[:, DELAY] = 0.0, 0.0, 0.0
        known[DELAY, DELAY] = 0.0 if synchronous else _DELAY**2
        return FilterEstimate(mean, known)

    def moved(self, offset: Float[np.ndarray, "5"], covariance: Float[np.ndarray, "5 5"]) -> "FilterEstimate":
        """With a drift from elsewhere; all else stays, and depends on it no more."""
        mean, known = self.mean.copy(), self.covariance.copy()
        mean[DRIFT] = offset
        known[DRIFT], known[:, DRIFT] = 0.0, 0.0
        known[DRIFT, DRIFT] = covariance
        return FilterEstimate(mean, known)

    def _widened(self, by: Float[np.ndarray, "k"]) -> "FilterEstimate":
        """By standard deviations of the first numbers."""
        variances = np.zeros(len(self.mean))
        variances[: len(by)] = by**2
        return replace(self, covariance=self.covariance + np.diag(variances))


def at_start(chart: RigChart, config: Config) -> FilterEstimate:
    """The rig that was given, and how far it may be off: by what its calibration left, a mixture taken as one normal
    distribution, and by how far it has drifted since."""
    left = _Left(config, chart)
    drift = [KNOCKED, _TURNED if left.covariance.any() else KNOCKED, KNOCKED, KNOCKED, KNOCKED]
    spread = np.array([*drift, 0.0 if config.synchronous else _DELAY, *config.heating])
    covariance = np.zeros((LEFT.start + chart.dim,) * 2)
    covariance[: LEFT.start, : LEFT.start] = np.diag(spread**2)
    covariance[LEFT, LEFT] = left.covariance
    return FilterEstimate(np.zeros(LEFT.start + chart.dim), covariance)


@dataclass(frozen=True, eq=False)
class _Left:
    """What a calibration leaves: one of several normal distributions of θ, or all as one."""

    config: Config
    chart: RigChart

    @cached_property
    def mixture(self) -> CalibrationPrior:
        return as_prior(self.config.prior, self.chart)

    @cached_property
    def covariances(self) -> Float[np.ndarray, "j n n"]:
        """Of each; the last one is that of all."""
        each = self.mixture.roots @ self.mixture.roots.swapaxes(1, 2)
        return np.concatenate([each, np.einsum("m,mij->ij", self.mixture.weights, each)[None]])

    @property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Of all."""
        return self.covariances[-1]


def likelier_prior(known: FilterEstimate, config: Config, chart: RigChart, which: int) -> tuple[int, np.ndarray]:
    """Which of the calibration's priors is most probable by now, if it is clearly more so than the one in use, and by
    how much information it exceeds that.

    Args:
        which: the one in use; -1: all as one.
    """
    left = _Left(config, chart)
    n, at, covariance = chart.dim, known.mean[LEFT], known.covariance[LEFT, LEFT]
    if not left.covariance.any():
        return which, np.zeros((n, n))
    units = np.sqrt(np.diag(left.covariance))
    priors = left.covariances / units[:, None] / units
    inverse, volume = np.linalg.inv(priors), np.linalg.slogdet(priors)[1]
    change = inverse - inverse[which]
    moved = np.eye(n) + covariance / units[:, None] / units @ change
    after = np.linalg.solve(moved, np.broadcast_to(at / units, (len(priors), n))[..., None])[..., 0]
    distance = np.einsum("i,jik,jk->j", at / units, change, after)
    evidence = -0.5 * (volume - volume[which] + np.linalg.slogdet(moved)[1] + distance)
    best = int(evidence.argmax())
    best = best if evidence[best] > evidence[which] + _CLEARLY else which % len(priors)
    return best - len(priors) if best == len(priors) - 1 else best, change[best] / units[:, None] / units


def _narrowed(
    covariance: Float[np.ndarray, "m m"], information: Float[np.ndarray, "m m"]
) -> tuple[Float[np.ndarray, "m m"], float]:
    """The covariance with some information more, and the logarithm of the determinant by which that narrows it. In
    units of what is known, as those of people differ by orders of magnitude; not by the inverse of the covariance,
    which what is exact does not have."""
    units = np.sqrt(np.maximum(np.diag(covariance), 1e-24))
    scaled = covariance / units[:, None] / units
    narrowed = np.eye(len(units)) + scaled @ (units[:, None] * information * units)
    after = units[:, None] * np.linalg.solve(narrowed, scaled) * units
    return 0.5 * (after + after.T), float(np.linalg.slogdet(narrowed)[1])


def _principal(a: Float[np.ndarray, "n n"]) -> tuple[Float[np.ndarray, "r"], Float[np.ndarray, "r n"]]:
    """The information that there is, and the directions that it is of: a = axesᵀ values axes."""
    units = np.sqrt(np.maximum(np.diag(a), 0.0))
    inverse = np.where(units > 0.0, 1.0 / np.where(units > 0.0, units, 1.0), 0.0)
    values, axes = np.linalg.eigh(a * inverse[:, None] * inverse)
    some = values > _NOT_MEASURED * max(float(values[-1]), _NOT_MEASURED)
    return values[some], axes[:, some].T * inverse
