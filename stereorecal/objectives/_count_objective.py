"""The stereo objective: the paper's count over the extrinsics around a rig."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial
from jaxtyping import Float

from stereorecal._arrays import product, refuse_tracers
from stereorecal.geometry import AnyView, StereoRig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives._charts import RigChart, count_chart
from stereorecal.objectives._parameters import EXTRINSICS, Reach, as_reach
from stereorecal.recordings import Pair, Pairs
from stereorecal.scoring import (
    Pyramid,
    ScoringData,
    bands,
    count_scaled,
    forward_gradient,
    host,
    pyramid,
    soft_count_scaled,
)
from stereorecal.scoring.host import with_measured_range
from stereorecal.strategies import Budget, Objective, Problem, Traced, as_budget


@dataclass(frozen=True, eq=False)
class StereoImages:
    """The pairs and the calibration at the start.

    Attributes:
        rig: the calibration that the run starts from; its intrinsics count as known, its extrinsics have drifted.
        pairs: the frames, full size, not rectified.
        chart: unit box to extrinsics (radians, metres) and back; the rig's own extrinsics lie at z = 0.
    """

    rig: StereoRig
    pairs: tuple[Pair, ...]
    chart: RigChart


@lru_cache
def _by_extrinsics(
    score: Callable[..., jax.Array], matcher: AbstractMatcher, *, smooth: bool
) -> Callable[..., jax.Array]:
    """The sum of a score over bands of the view, by a point of the box: one compiled function for each matcher."""

    def total(given: tuple[tuple[ScoringData, ...], jax.Array, jax.Array], z: jax.Array) -> jax.Array:
        data, centre, slopes = given
        extrinsics = centre + product(z, slopes)
        return jnp.sum(jnp.stack([score(band, extrinsics, matcher) for band in data]))

    return jax.jit(forward_gradient(total) if smooth else total)


def objective(
    rig: StereoRig,
    pairs: Pairs,
    *,
    matcher: AbstractMatcher | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    view: AnyView = None,
    scale: float = 1.0,
    rows: float = 1.0,
    budget: Budget | float | None = None,
) -> Objective:
    """The count of valid disparities as an objective over the unit box around the rig's extrinsics. Works on the host;
    its traced face (`objective.traced`) composes with JAX.

    Args:
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` the range is
            measured.
        reach: half widths of the box; default 3 degrees and 3 % of the baseline.
        view: default the view of `rig`.
        scale: image scale, (0, 1].
        rows: share of the rows that are scored, (0, 1], in bands of 32 spread over the view: a count for less, with its
            maximum in the same place and more noise (0.5 to 0.9 % with a quarter of the rows of 640x480).
        budget: in units, or a `Budget`; default unlimited.

    Raises:
        InputError: if images and calibration do not fit, or `rows` is not a share.
    """
    refuse_tracers("sr.objective", "its traced face, objective.traced.count, or sr.count", rig, pairs, view)
    images, reach = pyramid(rig, pairs, view), as_reach(reach)
    matcher = with_measured_range(matcher, images, float(np.radians(reach.degrees)))
    chart = count_chart(images.rig, reach)
    return count_objective(images, matcher, chart, scale=scale, rows=rows, budget=as_budget(budget))


def count_objective(
    images: Pyramid,
    matcher: AbstractMatcher,
    chart: RigChart,
    *,
    scale: float = 1.0,
    rows: float = 1.0,
    frames: int | None = None,
    budget: Budget | None = None,
) -> Objective:
    """`objective` of images that are prepared once, and a matcher whose disparity range is known; of at most so many
    frames. Where more than extrinsics is free, it is on the host alone, one candidate after the other."""
    whole = images.at(scale, frames)
    data = bands(whole, rows)
    cost = whole.cost * sum(band.pixels for band in data) / whole.pixels
    if not set(chart.names) <= set(EXTRINSICS):
        return Objective(Problem(chart.dim, lambda points: _counts_of_rigs(data, chart, points, matcher), cost), budget)
    unit = np.array([1.0, 1.0, 1.0, *[float(chart.rig.baseline)] * 3])  # scores see translations in baselines
    centre, slopes = chart.rig.extrinsics / unit, chart.extrinsic_slopes / unit

    def values(points: np.ndarray) -> np.ndarray:
        extrinsics = centre + points @ slopes
        return np.sum([host.counts(band, extrinsics, matcher) for band in data], axis=0, dtype=float)

    def traced(score: Callable[..., jax.Array], *, smooth: bool) -> Partial:
        given = (data, jnp.asarray(centre, jnp.float32), jnp.asarray(slopes, jnp.float32))
        return Partial(_by_extrinsics(score, matcher.scaled(scale), smooth=smooth), given)

    faces = Traced(
        count=traced(count_scaled, smooth=False) if matcher.traceable else None,
        soft_count=traced(soft_count_scaled, smooth=True) if matcher.smooth else None,
    )
    return Objective(Problem(chart.dim, values, cost, faces, StereoImages(images.rig, images.pairs, chart)), budget)


def _counts_of_rigs(
    data: tuple[ScoringData, ...], chart: RigChart, points: Float[np.ndarray, "k n"], matcher: AbstractMatcher
) -> Float[np.ndarray, "k"]:
    """The count under the rig at each point of the box."""
    found = np.zeros(len(points))
    for at, rig in enumerate(map(chart.rig_at, points)):
        extrinsics = with_unit_baseline(rig.extrinsics)[None]
        found[at] = sum(int(host.counts(band.through(rig), extrinsics, matcher)[0]) for band in data)
    return found
