"""The health of a rig, read off its state."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal.decision import Decision, Tolerances, Verdict, decide
from stereorecal.estimation import Errors, Estimate, Groups, PointwiseLoss, Posterior, errors_near, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS
from stereorecal.online._filter import DELAY, SIZE, FilterEstimate
from stereorecal.online._state import State, rig_with
from stereorecal.recalibration import DISTANCES, NORMAL_95, Condition, Interval

FAR = 30  # baselines
DEPTH_MATTERS = 5.0  # percent there
LATE = 4.0  # standard errors
LATE_MATTERS = 0.03  # frames
_GAIN = 1.0  # of the expected loss: a change that gains less is none
_ROTATION = EXTRINSICS[:3]  # y and z are left alone where a late shutter could pose as them
_UNKNOWN = Interval(float("nan"), float("nan"), float("nan"))


@dataclass(frozen=True, eq=False)
class Judgement:
    """The decision on a calibration in use, each part of it when it is asked for.

    Attributes:
        estimate: what is known of the rig, as changes of the calibration in use.
        loss: what is to be lost by such changes.
        free: names of the parameters that may be switched.
        limits: of the decision.
        harm: chance of harm that a trial may take.
    """

    estimate: Estimate
    loss: PointwiseLoss
    free: tuple[str, ...]
    limits: Tolerances
    harm: float

    @cached_property
    def settled(self) -> bool:
        """Whether nothing can be gained by any change, and rows are aligned for sure: what `decide` would say of most
        pairs, in a hundredth of its time."""
        errors, (centres,), (deviations,) = self.loss.errors, self.loss.centres, self.loss.deviations
        if self.loss.expected(np.zeros_like(centres)) - self.loss.expected(centres) >= _GAIN:
            return False
        rows, _ = np.split(np.abs(centres) + NORMAL_95 * deviations, 2)
        return bool(errors.matters.rows_px * (errors.seen @ rows) <= self.limits.good_rows_px)

    @cached_property
    def decision(self) -> Decision:
        """Whether to change what is free."""
        return decide(self.estimate, self.free, self.limits)

    @cached_property
    def change(self) -> Float[np.ndarray, "5"] | None:
        """What the decision asks for; or what is better on average, and not for sure: later pairs may prove it, and one
        can go back."""
        if self.settled:
            return None
        if not self.decision.refused:
            return self.decision.theta[:SIZE]
        trial = decide(self.estimate, self.free, replace(self.limits, harm=self.harm))
        better = trial.loss[1] < trial.loss[0] - _GAIN and trial.worse <= self.harm
        return trial.theta[:SIZE] if better else None

    @cached_property
    def shifted(self) -> bool:
        """Whether only a change of y and z as well would be better for sure."""
        if self.free == EXTRINSICS or self.settled:
            return False
        # Over the whole view, since a shift is seen near by, which few images show.
        left = self.decision.view_px[0 if self.decision.refused else 1, 0]
        return bool(left > self.limits.good_rows_px) and not decide(self.estimate, EXTRINSICS, self.limits).refused


@dataclass(frozen=True, eq=False)
class Reading:
    """How the calibration in use stands to the true one, fused over all looks so far. Intervals are of 95 %.

    Attributes:
        axes: how far the rig has drifted from it: pitch, yaw, roll in degrees, y, z in percent of the baseline.
        row_error: of the last look, pixels at full size: the mean over tiles of a tile's median |row difference|.
        delay: of the right shutter, in frames.
        judged: the decision whether to change pitch, yaw and roll, and with `Config.synchronous` y and z, too; None if
            the state holds what is no number.
    """

    axes: Mapping[str, Interval]
    row_error: float
    delay: Interval
    judged: Judgement | None

    @property
    def decision(self) -> Decision | None:
        """Whether to change what may be switched; None if the state holds what is no number."""
        return self.judged and self.judged.decision

    @property
    def shifted(self) -> bool:
        """Whether only a change of y and z as well would be better for sure. A bar that bends turns the cameras too; a
        shutter that is late on a rig that travels straight on looks like a shift."""
        return self.judged is not None and self.judged.shifted

    @property
    def change(self) -> Float[np.ndarray, "5"] | None:
        """(5,) of pitch, yaw, roll [deg], y, z [percent], which the decision asks for, or which is better on average by
        what is noticed and harms as seldom as it may; None where none is."""
        return None if self.judged is None else self.judged.change

    @cached_property
    def rows_px(self) -> Interval:
        """Epipolar error of the calibration in use, over the view, pixels at full size."""
        return _UNKNOWN if self.judged is None else Interval(*self.judged.decision.rows_px[0].tolist())

    @cached_property
    def depth_percent(self) -> Mapping[int, Interval]:
        """Its error of depth at 5, 10, 30 and 100 baselines."""
        if self.judged is None:
            return dict.fromkeys(DISTANCES, _UNKNOWN)
        estimate = self.judged.estimate
        ends = estimate.depth_error_percent(np.zeros(len(estimate.names)))
        return {distance: Interval(*of_distance) for distance, of_distance in ends.items()}

    @property
    def condition(self) -> Condition:
        """What the decision says, as `health` has it; a calibration is not healthy while a shutter is late, or another
        one is better on average, and goes on trial."""
        if self.judged is None:
            return Condition.CANNOT_TELL
        if self.judged.settled:
            return Condition.CANNOT_TELL if self.late else Condition.HEALTHY
        if self.repairs or self.shifted:
            return Condition.REPAIR
        good = self.judged.decision.verdict is Verdict.GOOD and self.change is None and not self.late
        return Condition.HEALTHY if good else Condition.CANNOT_TELL

    @property
    def repairs(self) -> bool:
        """Whether another calibration is better for sure."""
        return self.judged is not None and not self.judged.settled and not self.judged.decision.refused

    @property
    def matters(self) -> bool:
        """Whether epipolar errors are, as likely as not, none of a good calibration, or depth at 30 baselines is wrong
        by 5 %."""
        limits = Tolerances() if self.judged is None else self.judged.limits
        return self.rows_px.value > limits.good_rows_px or abs(self.depth_percent[FAR].value) > DEPTH_MATTERS

    @property
    def late(self) -> bool:
        """Whether a shutter is late: by 4 standard errors, and 0.03 frames."""
        half = (self.delay.high - self.delay.low) / 2.0
        return abs(self.delay.value) > max(LATE * half / NORMAL_95, LATE_MATTERS)

    def as_dict(self) -> dict:
        """Plain data for JSON."""
        return json_data(
            {
                "condition": self.condition.name.lower(),
                "shifted": self.shifted,
                "probability_better": self.decision and self.decision.better,
                "probability_worse": self.decision and self.decision.worse,
                "axes": {name: axis.as_dict() for name, axis in self.axes.items()},
                "row_error_px": self.row_error,
                "rows_px": self.rows_px.as_dict(),
                "depth_percent": {distance: error.as_dict() for distance, error in self.depth_percent.items()},
                "delay_frames": self.delay.as_dict(),
            }
        )


def reading(state: State) -> Reading:
    """What a state says of the calibration in use."""
    offset, delay = state.estimate.offset - state.using, state.estimate.delay
    widths = NORMAL_95 * np.sqrt(np.diag(state.estimate.covariance))
    axes = {
        name: Interval(value, value - width, value + width)
        for name, value, width in zip(EXTRINSICS, offset.tolist(), widths[:SIZE].tolist(), strict=True)
    }
    late = Interval(delay, delay - float(widths[DELAY]), delay + float(widths[DELAY]))
    return Reading(axes, state.row_error, late, judged(state) if state.estimate.is_finite else None)


def judged(state: State) -> Judgement:
    """The decision on the calibration in use."""
    config, using = state.config, tuple(state.using.tolist())
    free = EXTRINSICS if config.synchronous else _ROTATION
    return _judged(state.initial, using, state.estimate, state.view, free, config.tolerances, config.harm, state.shown)


@lru_cache(maxsize=4)  # a step asks several times
def _judged(
    initial: StereoRig,
    using: tuple[float, ...],
    filtered: FilterEstimate,
    view: View,
    free: tuple[str, ...],
    limits: Tolerances,
    harm: float,
    shown: Groups | None,
) -> Judgement:
    errors, mean = _errors(initial, using, view, limits, shown), filtered.theta
    mean[:SIZE] -= using
    posterior = Posterior(np.ones(1), mean[None], filtered.of_theta[None])
    variances = np.diag(posterior.covariance)
    estimate = Estimate(errors.chart, posterior, (0.0, 0.0), 0, float("nan"), variances, view=view, seen=shown)
    return Judgement(estimate, PointwiseLoss.under(errors, posterior), free, limits, harm)


@lru_cache(maxsize=2)  # the same for some looks
def _errors(
    initial: StereoRig, using: tuple[float, ...], view: View, limits: Tolerances, shown: Groups | None
) -> Errors:
    """What errors of the calibration in use do to rows and depth."""
    chart = rig_parameters(rig_with(initial, np.array(using)))
    return errors_near(chart, np.zeros(chart.dim), limits.matters, view, shown)
