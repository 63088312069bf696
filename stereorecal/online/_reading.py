"""The health of a rig, read off its state: what the filter knows, as the decision takes it, an estimate around the
calibration in use; and what it knows before the first look.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal.decision import Decision, Tolerances, Verdict, decide
from stereorecal.estimation import (
    CalibrationCovariance,
    Estimate,
    Posterior,
    Prior,
    as_prior,
    consequences,
    is_exact,
    rig_parameters,
)
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._filter import KEYSTONE, SIZE, FilterEstimate, at_start
from stereorecal.online._state import State, rig_with
from stereorecal.recalibration import DISTANCES, NORMAL_95, Condition, Interval

_SHIFTS = np.array([index for index, name in enumerate(EXTRINSICS) if name != "yaw"])
_YAW, _PRINCIPAL_POINT = EXTRINSICS.index("yaw"), "right.cx"
_ROWS_AT, _DEPTH_AT = 10, 30  # baselines, as a keystone is measured
FAR = 30  # baselines
DEPTH_MATTERS = 5.0  # percent there
LATE = 4.0  # standard errors
LATE_MATTERS = 0.03  # frames
_ROTATION = EXTRINSICS[:3]  # y and z are left alone where a late shutter could pose as them
_UNKNOWN = Interval(float("nan"), float("nan"), float("nan"))


def known(initial: StereoRig, using: tuple[float, ...], filtered: FilterEstimate, view: View) -> Estimate:
    """The posterior of the rig, as changes of the calibration in use, whose offset from the initial one is `using`;
    rows and depth are judged in a view."""
    chart, keystone = chart_and_keystone(initial, using, view)
    numbers = [*range(SIZE), KEYSTONE]
    ways = np.column_stack([np.eye(chart.dim)[:, :SIZE], keystone])
    true = rig_with(initial, filtered.offset)
    mean = chart.coordinates(np.asarray(true.extrinsics, float)) + filtered.keystone * keystone
    covariance = ways @ filtered.covariance[np.ix_(numbers, numbers)] @ ways.T
    posterior = Posterior(np.ones(1), mean[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 0, float("nan"), np.diag(covariance), view=view)


def prior_now(state: State) -> Prior:
    """What is known of the calibration in use, for an estimate by other pairs: of exact intrinsics only that they are;
    else its errors, with the keystone, which rows show and no change of the extrinsics should take up."""
    if is_exact(state.config.prior) or not state.estimate.is_finite:
        return state.config.prior
    posterior = known(state.initial, tuple(state.using.tolist()), state.estimate, state.view).posterior
    names = rig_parameters(state.rig).names
    some = [index for index, variance in enumerate(np.diag(posterior.covariance)) if variance > 0.0]
    covariance = posterior.covariance[np.ix_(some, some)]
    return CalibrationCovariance([names[index] for index in some], covariance, posterior.mean[some])


def filtered_by(state: State, estimate: Estimate, trusted: float) -> FilterEstimate:
    """The filter's estimate that knows of offset and keystone what an estimate by some pairs does: the inverse of
    `known`.

    Args:
        estimate: with `prior_now` as its prior, of changes of the calibration in use.
        trusted: standard deviation of what these pairs may have in common, degrees and percent of the baseline.
    """
    chart, keystone = chart_and_keystone(state.initial, tuple(state.using.tolist()), state.view)
    principal_point = chart.names.index(_PRINCIPAL_POINT)
    numbers = np.eye(SIZE + 1, chart.dim)
    numbers[SIZE] = np.eye(chart.dim)[principal_point] / keystone[principal_point]
    numbers[:SIZE] -= np.outer(keystone[:SIZE], numbers[SIZE])
    offset = np.pad(numbers[:SIZE] @ estimate.theta, (0, chart.dim - SIZE))
    covariance = numbers @ estimate.posterior.covariance @ numbers.T
    covariance[:SIZE, :SIZE] += trusted**2 * np.eye(SIZE)
    mean = np.append(state.offset_of(chart.rig_at(offset)), numbers[SIZE] @ estimate.theta)
    return state.estimate.told(mean, covariance)


@lru_cache(maxsize=2)  # the same until another calibration is in use
def chart_and_keystone(
    initial: StereoRig, using: tuple[float, ...], view: View
) -> tuple[RigChart, Float[np.ndarray, "n"]]:
    """Changes of the calibration in use; and a degree of keystone in their units, the rows of a yaw that is none of
    depth: a yaw, and the principal point that undoes it in depth, as much of both as bends rows like a degree of yaw
    (of a lens with distortion, principal points bend them, too)."""
    chart = rig_parameters(rig_with(initial, np.array(using)))
    rows, depth = _rows_and_depth(chart, view)
    principal_point, way = chart.names.index(_PRINCIPAL_POINT), np.zeros(chart.dim)
    way[_YAW], way[principal_point] = 1.0, -depth[_YAW] / depth[principal_point]
    like_yaw = (rows @ way) @ rows[:, _YAW] / (rows[:, _YAW] @ rows[:, _YAW])
    return chart, way / like_yaw


def _rows_and_depth(chart: RigChart, view: View) -> tuple[Float[np.ndarray, "p n"], Float[np.ndarray, "n"]]:
    """What each parameter does to rows, and to depth over the view."""
    near = consequences(chart, np.zeros(chart.dim), (_ROWS_AT, _DEPTH_AT), view)
    return near.rows[0], near.mean_nearness[1]


def before_looks(state: State) -> FilterEstimate:
    """What the filter knows before the first look: the rig was calibrated, so that something will show a yaw that it
    has turned by; and intrinsics that are wrong bend rows like a keystone, as a yaw does, which is none.

    The yaw with which depth is right, and that with which rows lie straight less that, are as wide as the calibrations
    that are thought possible leave them on average; if the intrinsics are right, no keystone is left, and the yaw as
    any other angle.
    """
    config, deviations = state.config, state.prior
    if is_exact(config.prior):
        return at_start(deviations, config)
    chart = rig_parameters(state.initial)
    (rows, depth), own = _rows_and_depth(chart, state.view), len(EXTRINSICS)
    by_rows = np.linalg.lstsq(rows[:, :own], rows, rcond=None)[0]  # (5, n)
    by_depth = (depth - depth[_SHIFTS] @ by_rows[_SHIFTS]) / depth[_YAW]
    prior = as_prior(config.prior, chart)
    both = np.stack([by_depth, by_rows[_YAW] - by_depth])
    deviations[_YAW], keystone = prior.weights @ np.linalg.norm(both @ prior.roots, axis=-1)
    return at_start(deviations, config, float(keystone))


@dataclass(frozen=True, eq=False)
class Reading:
    """How the calibration in use stands to the true one, fused over all looks so far. Intervals are of 95 %.

    Attributes:
        axes: what would correct it: pitch, yaw, roll in degrees, y, z in percent of the baseline.
        row_error: of the last look, pixels at full size: the mean over tiles of a tile's median |row difference|.
        rows_px: epipolar error of the calibration in use, over the view, pixels at full size.
        delay: of the right shutter, in frames.
        decision: whether to change pitch, yaw and roll, and with `Config.synchronous` y and z, too; None if the state
            holds what is no number.
        shifted: whether only a change of y and z as well would be better for sure. A bar that bends turns the cameras
            too; a shutter that is late on a rig that travels straight on looks like a shift.
        estimate: of changes of the calibration in use; None without a decision.
    """

    axes: Mapping[str, Interval]
    row_error: float
    rows_px: Interval
    delay: Interval
    decision: Decision | None
    shifted: bool
    estimate: Estimate | None = None

    @cached_property
    def depth_percent(self) -> Mapping[int, Interval]:
        """The error of depth of the calibration in use at 5, 10, 30 and 100 baselines."""
        if self.estimate is None:
            return dict.fromkeys(DISTANCES, _UNKNOWN)
        estimate = replace(self.estimate)  # whose samples, some megabytes, go again: readings are kept for curves
        found = estimate.depth_error_percent(np.zeros(len(estimate.names)))
        return {int(distance): Interval(*ends) for distance, ends in found.items()}

    @property
    def condition(self) -> Condition:
        """What the decision says, as `health` has it; a calibration is not healthy while a shutter is late."""
        if self.decision is None:
            return Condition.CANNOT_TELL
        if self.change is not None or self.shifted:
            return Condition.REPAIR
        good = self.decision.verdict is Verdict.GOOD and not self.late
        return Condition.HEALTHY if good else Condition.CANNOT_TELL

    @property
    def change(self) -> Float[np.ndarray, "5"] | None:
        """Of pitch, yaw, roll [deg], y, z [percent], that the decision asks for; None where it asks for none."""
        return None if self.decision is None or self.decision.refused else self.decision.theta[:SIZE]

    @property
    def matters(self) -> bool:
        """Whether epipolar errors are, as likely as not, none of a good calibration, or depth at 30 baselines is wrong
        by 5 %."""
        limits = Tolerances() if self.decision is None else self.decision.tolerances
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
    offset = state.estimate.offset - state.using
    widths = NORMAL_95 * np.sqrt(np.diag(state.estimate.covariance))
    delay = state.estimate.delay
    axes = {
        name: Interval(value, value - width, value + width)
        for name, value, width in zip(state.chart.names, offset.tolist(), widths[:SIZE].tolist(), strict=True)
    }
    late = Interval(delay, delay - float(widths[SIZE]), delay + float(widths[SIZE]))
    if not state.estimate.is_finite:
        return Reading(axes, state.row_error, _UNKNOWN, late, None, shifted=False)
    config = state.config
    using, free = tuple(state.using.tolist()), EXTRINSICS if config.synchronous else _ROTATION
    estimate, decision, shifted = _decided(
        state.initial, using, state.estimate, state.view, free, config.limits, config.tolerances
    )
    rows = Interval(*decision.rows_px[0].tolist())
    return Reading(axes, state.row_error, rows, late, decision, shifted, estimate)


@lru_cache(maxsize=4)  # a step asks several times
def _decided(
    initial: StereoRig,
    using: tuple[float, ...],
    filtered: FilterEstimate,
    view: View,
    free: tuple[str, ...],
    limits: Tolerances,
    of_recordings: Tolerances,
) -> tuple[Estimate, Decision, bool]:
    """Of a calibration in use what is known, the decision on what may be switched, and whether it is shifted, as a
    recording would tell: no switch corrects that."""
    estimate = known(initial, using, filtered, view)
    found = decide(estimate, free, limits)
    left = found.rows_px[0 if found.refused else 1, 0]
    beyond = free != EXTRINSICS and found.verdict is not Verdict.GOOD and bool(left > limits.good_rows_px)
    posterior = estimate.posterior
    if not found.refused:  # what the rotation alone repairs is no shift
        posterior = replace(posterior, means=posterior.means - found.theta)
    shifted = beyond and not decide(replace(estimate, posterior=posterior), EXTRINSICS, of_recordings).refused
    return replace(estimate), found, shifted
