"""The stereo objective: the paper's count over the extrinsics around a rig."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np

from stereorecal.geometry import Pair, StereoRig, View, view as default_view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.scoring import count, counts, prepare, with_disparity_range
from stereorecal.strategies._budget import Budget
from stereorecal.strategies._chart import Reach, chart_around, dimensionless
from stereorecal.strategies._images import Images
from stereorecal.strategies._objective import Objective, Problem, Traced


def objective(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    matcher: AbstractMatcher | None = None,
    reach: Reach | None = None,
    view: View | None = None,
    scale: float = 1.0,
    budget: Budget | None = None,
) -> Objective:
    """The count of valid disparities as an objective over the unit box around the rig's extrinsics.

    Args:
        matcher: default `SAD()`; without `num_disparities` the range is measured.
        reach: half widths of the box; default 3 degrees and 3 % of the baseline.
        view: default the view of `rig`.
        scale: image scale, (0, 1].
        budget: default unlimited.

    Raises:
        InputError: if images and calibration do not fit.
    """
    reach = reach or Reach()
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, pairs, view, np.radians(reach.degrees))
    matcher = matcher.scaled(scale)
    data = prepare(rig, pairs, view, scale)
    metric_chart = chart_around(rig, reach)
    chart = dimensionless(metric_chart)

    def values(points: np.ndarray) -> np.ndarray:
        return counts(data, chart.extrinsics(points), matcher).astype(float)

    def traced_count(z: jax.Array) -> jax.Array:
        return count(data, chart.extrinsics(jnp.asarray(z, jnp.float32)), matcher)

    traced = Traced(count=traced_count) if matcher.traceable else Traced()
    images = Images(rig, tuple(pairs), metric_chart)
    return Objective(Problem(chart.dim, values, len(pairs) * scale**2, traced, images), budget)
