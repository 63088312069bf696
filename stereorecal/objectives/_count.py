"""The stereo objective: the paper's count over the extrinsics around a rig."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from stereorecal._errors import InputError
from stereorecal._pytree import register_pytree
from stereorecal.geometry import StereoRig, View, view as default_view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.objectives._chart import Chart, Reach, chart_around, dimensionless
from stereorecal.objectives._images import Images
from stereorecal.recordings import Pair
from stereorecal.scoring import (
    ScoringData,
    bands,
    count,
    counts,
    forward_gradient,
    prepare,
    soft_count,
    with_disparity_range,
)
from stereorecal.strategies._budget import Budget
from stereorecal.strategies._objective import Objective, Problem, Traced


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoCount:
    """The count as a function of a point of the unit box."""

    data: tuple[ScoringData, ...]
    chart: Chart
    matcher: AbstractMatcher = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        extrinsics = self.chart.extrinsics(z)
        return jnp.sum(jnp.stack([count(band, extrinsics, self.matcher) for band in self.data]))


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoSoftCount:
    """The soft count as a function of a point of the unit box; differentiable in reverse."""

    data: tuple[ScoringData, ...]
    chart: Chart
    matcher: AbstractMatcher = field(metadata={"static": True})
    temperature: float = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        return _differentiable_soft_count(self, z)


@forward_gradient
def _differentiable_soft_count(score: StereoSoftCount, z: jax.Array) -> jax.Array:
    extrinsics = score.chart.extrinsics(z)
    parts = [soft_count(band, extrinsics, score.matcher, score.temperature) for band in score.data]
    return jnp.sum(jnp.stack(parts))


def objective(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    matcher: AbstractMatcher | None = None,
    reach: Reach | None = None,
    view: View | None = None,
    scale: float = 1.0,
    rows: float = 1.0,
    temperature: float = 0.1,
    budget: Budget | None = None,
) -> Objective:
    """The count of valid disparities as an objective over the unit box around the rig's extrinsics.

    Args:
        matcher: default `SAD()`; without `num_disparities` the range is measured.
        reach: half widths of the box; default 3 degrees and 3 % of the baseline.
        view: default the view of `rig`.
        scale: image scale, (0, 1].
        rows: share of the rows that are scored, (0, 1], in bands of 32 spread over the view: a count for less, with its
            maximum in the same place and more noise (0.5 to 0.9 % with a quarter of the rows of 640x480).
        temperature: width of the gates of the soft count, dimensionless.
        budget: default unlimited.

    Raises:
        InputError: if images and calibration do not fit, the temperature is not positive, or `rows` is not a share.
    """
    if not temperature > 0:
        raise InputError(f"a temperature of {temperature} makes no sense; give a positive number, such as 0.1.")
    reach = reach or Reach()
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, pairs, view, np.radians(reach.degrees))
    matcher = matcher.scaled(scale)
    whole = prepare(rig, pairs, view, scale)
    data = bands(whole, rows)
    cost = len(pairs) * scale**2 * sum(band.pixels for band in data) / whole.pixels
    metric_chart = chart_around(rig, reach)
    chart = dimensionless(metric_chart)
    traced_chart = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), chart)

    def values(points: np.ndarray) -> np.ndarray:
        extrinsics = chart.extrinsics(points)
        return np.sum([counts(band, extrinsics, matcher) for band in data], axis=0, dtype=float)

    traced = Traced(
        count=StereoCount(data, traced_chart, matcher) if matcher.traceable else None,
        soft_count=StereoSoftCount(data, traced_chart, matcher, temperature) if matcher.smooth else None,
    )
    images = Images(rig, tuple(pairs), metric_chart)
    return Objective(Problem(chart.dim, values, cost, traced, images), budget)
