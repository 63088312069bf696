"""The stereo objective: the paper's count over the extrinsics around a rig."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from stereorecal._errors import InputError
from stereorecal._pytree import register_pytree
from stereorecal.geometry import Pair, StereoRig, View, view as default_view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.scoring import (
    ScoringData,
    count,
    counts,
    forward_gradient,
    prepare,
    soft_count,
    with_disparity_range,
)
from stereorecal.strategies._budget import Budget
from stereorecal.strategies._chart import Chart, Reach, chart_around, dimensionless
from stereorecal.strategies._images import Images
from stereorecal.strategies._objective import Objective, Problem, Traced


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoCount:
    """The count as a function of a point of the unit box."""

    data: ScoringData
    chart: Chart
    matcher: AbstractMatcher = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        return count(self.data, self.chart.extrinsics(z), self.matcher)


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoSoftCount:
    """The soft count as a function of a point of the unit box; differentiable in reverse."""

    data: ScoringData
    chart: Chart
    matcher: AbstractMatcher = field(metadata={"static": True})
    temperature: float = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        return _differentiable_soft_count(self, z)


@forward_gradient
def _differentiable_soft_count(score: StereoSoftCount, z: jax.Array) -> jax.Array:
    return soft_count(score.data, score.chart.extrinsics(z), score.matcher, score.temperature)


def objective(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    matcher: AbstractMatcher | None = None,
    reach: Reach | None = None,
    view: View | None = None,
    scale: float = 1.0,
    temperature: float = 0.1,
    budget: Budget | None = None,
) -> Objective:
    """The count of valid disparities as an objective over the unit box around the rig's extrinsics.

    Args:
        matcher: default `SAD()`; without `num_disparities` the range is measured.
        reach: half widths of the box; default 3 degrees and 3 % of the baseline.
        view: default the view of `rig`.
        scale: image scale, (0, 1].
        temperature: width of the gates of the soft count, dimensionless.
        budget: default unlimited.

    Raises:
        InputError: if images and calibration do not fit, or the temperature is not positive.
    """
    if not temperature > 0:
        raise InputError(f"a temperature of {temperature} makes no sense; give a positive number, such as 0.1.")
    reach = reach or Reach()
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, pairs, view, np.radians(reach.degrees))
    matcher = matcher.scaled(scale)
    data = prepare(rig, pairs, view, scale)
    metric_chart = chart_around(rig, reach)
    chart = dimensionless(metric_chart)
    traced_chart = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), chart)

    def values(points: np.ndarray) -> np.ndarray:
        return counts(data, chart.extrinsics(points), matcher).astype(float)

    traced = Traced(
        count=StereoCount(data, traced_chart, matcher) if matcher.traceable else None,
        soft_count=StereoSoftCount(data, traced_chart, matcher, temperature) if matcher.smooth else None,
    )
    images = Images(rig, tuple(pairs), metric_chart)
    return Objective(Problem(chart.dim, values, len(pairs) * scale**2, traced, images), budget)
