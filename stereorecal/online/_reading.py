"""The health of a rig, read off its state: what the filter knows, as the decision takes it, an estimate around the
calibration in use.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal.decision import Decision, Tolerances, Verdict, decide
from stereorecal.estimation import Consequences, Estimate, Mixture, consequences, points_of_view, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._filter import SIZE
from stereorecal.online._matches import no_coverage, part_of
from stereorecal.online._state import State, rig_with, theta_of
from stereorecal.recalibration import DISTANCES, NORMAL_95, Condition, Interval

_SAMPLES = 500  # a chance of a fifth to a fiftieth
FAR = 30  # baselines
DEPTH_MATTERS = 5.0  # percent there
LATE = 4.0  # standard errors
LATE_MATTERS = 0.03  # frames
_ROTATION = EXTRINSICS[:3]  # y and z are left alone where a late shutter could pose as them


@lru_cache(maxsize=4)  # the same until another calibration is in use
def around(
    initial: StereoRig, using: tuple[float, ...], view: View, distances: tuple[float, ...]
) -> tuple[RigChart, Consequences]:
    """Changes of all parameters of the calibration in use, whose offset from the initial one is `using`; and what they
    do over the view at distances [baselines], and at a last set of points: one in the middle of each part of the view
    at each of DISTANCES, in the order of coverage."""
    chart = rig_parameters(rig_with(initial, using))
    middles = np.zeros((*no_coverage().shape, 3))
    for index, distance in enumerate(DISTANCES):
        points = points_of_view(chart.rig, distance, view)
        part = part_of(chart.rig, points)
        for number in range(len(middles)):
            some = points[part == number] if (part == number).any() else points
            middles[number, index] = some[len(some) // 2]
    return chart, consequences(chart, np.zeros(chart.dim), distances, view, [middles.reshape(-1, 3)])


@dataclass(frozen=True, eq=False)
class Reading:
    """How the calibration in use stands to the true one, fused over all looks so far. Intervals are of 95 %.

    Attributes:
        axes: what would correct it: pitch, yaw, roll in degrees, y, z in percent of the baseline.
        row_error: of the last look, pixels at full size: the mean over tiles of a tile's median |row difference|.
        rows_px: epipolar error of the calibration in use, over the view, pixels at full size.
        delay: of the right shutter, in frames.
        decision: whether to change pitch, yaw and roll, and with `Config.synchronous` y and z, too.
        shifted: whether only a change of y and z as well would be better for sure. A bar that bends turns the cameras
            too; a shutter that is late on a rig that travels straight on looks like a shift.
        estimate: of changes of the calibration in use.
    """

    axes: Mapping[str, Interval]
    row_error: float
    rows_px: Interval
    delay: Interval
    decision: Decision
    shifted: bool
    estimate: Estimate

    @cached_property
    def depth_percent(self) -> Mapping[int, Interval]:
        """The error of depth of the calibration in use at 5, 10, 30 and 100 baselines."""
        estimate = replace(self.estimate)  # whose samples, some megabytes, go again: readings are kept for curves
        found = estimate.depth_error_percent(np.zeros(len(estimate.names)))
        return {int(distance): Interval(*ends) for distance, ends in found.items()}

    @property
    def condition(self) -> Condition:
        """What the decision says, as `health` has it; a calibration is not healthy while a shutter is late."""
        if self.change is not None or self.shifted:
            return Condition.REPAIR
        good = self.decision.verdict is Verdict.GOOD and not self.late
        return Condition.HEALTHY if good else Condition.CANNOT_TELL

    @property
    def change(self) -> Float[np.ndarray, "5"] | None:
        """The change of pitch, yaw, roll [deg], y, z [percent] that the decision asks for; None if it asks for none."""
        return None if self.decision.refused else self.decision.theta[:SIZE]

    @property
    def matters(self) -> bool:
        """Whether epipolar errors are, as likely as not, none of a good calibration, or depth at 30 baselines is wrong
        by 5 %."""
        good_rows_px = self.decision.tolerances.good_rows_px
        return self.rows_px.value > good_rows_px or abs(self.depth_percent[FAR].value) > DEPTH_MATTERS

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
                "probability_better": self.decision.better,
                "probability_worse": self.decision.worse,
                "axes": dict(self.axes),
                "row_error_px": self.row_error,
                "rows_px": self.rows_px,
                "depth_percent": dict(self.depth_percent),
                "delay_frames": self.delay,
            }
        )


def reading(state: State) -> Reading:
    """What a state says of the calibration in use."""
    late = _interval(state.estimate.delay, state.estimate.of_delay)
    offset, variances = (state.offset - state.using).tolist(), np.diag(state.of_offset).tolist()
    axes = {name: _interval(*both) for name, both in zip(EXTRINSICS, zip(offset, variances, strict=True), strict=True)}
    config, using, coverage = state.config, tuple(state.using.tolist()), state.coverage.tobytes()
    free = EXTRINSICS if config.synchronous else _ROTATION
    given = (state.initial, using, state.posterior, state.view, coverage)
    estimate, decision, shifted = _decided(*given, free, config.limits, config.tolerances)
    rows = Interval(*decision.rows_px[0].tolist())
    return Reading(axes, state.row_error, rows, late, decision, shifted, estimate)


def _interval(mean: float, variance: float) -> Interval:
    half = NORMAL_95 * float(np.sqrt(variance))
    return Interval(mean, mean - half, mean + half)


@lru_cache(maxsize=4)  # a step asks several times
def _decided(
    initial: StereoRig,
    using: tuple[float, ...],
    of_rig: Mixture,
    view: View,
    coverage: bytes,
    free: tuple[str, ...],
    limits: Tolerances,
    of_recordings: Tolerances,
) -> tuple[Estimate, Decision, bool]:
    """What is known of a calibration in use, rows and depth being judged in a view, and where looks showed something;
    the decision on what may be switched; and whether it is shifted, as a recording would tell: no switch corrects
    that."""
    chart, near = around(initial, using, view, limits.distances)
    looks = np.frombuffer(coverage, int)
    looks = looks if looks.any() else np.ones(len(looks))
    posterior = replace(of_rig, means=of_rig.means - theta_of(np.array(using), chart))
    estimate = Estimate(
        chart,
        posterior,
        (0.0, 0.0),
        0,
        float("nan"),
        np.diag(posterior.covariance),
        points=(near.points[near.which == len(near.distances)], looks / looks.sum()),
        matters=limits.matters,
        view=view,
        samples=_SAMPLES,
        slopes=near,
    )
    found = decide(estimate, free, limits)
    left = found.rows_px[0 if found.refused else 1, 0]
    beyond = free != EXTRINSICS and found.verdict is not Verdict.GOOD and bool(left > limits.good_rows_px)
    if not found.refused:  # what the rotation alone repairs is no shift
        posterior = replace(posterior, means=posterior.means - found.theta)
    shifted = beyond and not decide(replace(estimate, posterior=posterior), EXTRINSICS, of_recordings).refused
    return replace(estimate), found, shifted
