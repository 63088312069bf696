"""The stereo objective: the paper's count over the extrinsics around a rig."""

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, refuse_tracers, register_pytree
from stereorecal.geometry import AnyView, StereoRig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives._charts import Chart, RigChart, count_chart
from stereorecal.objectives._parameters import EXTRINSICS, Reach, as_reach
from stereorecal.recordings import Pair, Pairs
from stereorecal.scoring import (
    TEMPERATURE,
    Pyramid,
    ScoringData,
    bands,
    checked_temperature,
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
    chart: Chart


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoCount:
    """The count as a function of a point of the unit box; compiled at its first call.

    Attributes:
        data: bands of the view, whose counts add up.
        matcher: with its disparity range at the scale of the data.
    """

    data: tuple[ScoringData, ...]
    chart: Chart
    matcher: AbstractMatcher = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        return _count(self, z)


@jax.jit
def _count(score: StereoCount, z: Float[jax.Array, "n"]) -> jax.Array:
    extrinsics = score.chart.extrinsics(z)
    return jnp.sum(jnp.stack([count_scaled(band, extrinsics, score.matcher) for band in score.data]))


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoSoftCount:
    """The soft count as a function of a point of the unit box; compiled at its first call, differentiable in any mode.
    Its temperature is the width of the gates, dimensionless."""

    data: tuple[ScoringData, ...]
    chart: Chart
    temperature: Float[AnyArray, ""]
    matcher: AbstractMatcher = field(metadata={"static": True})

    def __call__(self, z: jax.Array) -> jax.Array:
        return _soft_count(self, z)


@jax.jit
@forward_gradient
def _soft_count(score: StereoSoftCount, z: jax.Array) -> jax.Array:
    extrinsics = score.chart.extrinsics(z)
    parts = [soft_count_scaled(band, extrinsics, score.matcher, score.temperature) for band in score.data]
    return jnp.sum(jnp.stack(parts))


def objective(
    rig: StereoRig,
    pairs: Pairs,
    *,
    matcher: AbstractMatcher | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    view: AnyView = None,
    scale: float = 1.0,
    rows: float = 1.0,
    temperature: float = TEMPERATURE,
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
        temperature: width of the gates of the soft count, dimensionless.
        budget: in units, or a `Budget`; default unlimited.

    Raises:
        InputError: if images and calibration do not fit, the temperature is not positive, or `rows` is not a share.
    """
    refuse_tracers("sr.objective", "its traced face, objective.traced.count, or sr.count", rig, pairs, view)
    images, reach = pyramid(rig, pairs, view), as_reach(reach)
    matcher = with_measured_range(matcher, images, float(np.radians(reach.degrees)))
    options = {"scale": scale, "rows": rows, "temperature": temperature, "budget": as_budget(budget)}
    return count_objective(images, matcher, reach, **options)


def count_objective(
    images: Pyramid,
    matcher: AbstractMatcher,
    reach: Reach,
    *,
    free: tuple[str, ...] = EXTRINSICS,
    scale: float = 1.0,
    rows: float = 1.0,
    frames: int | None = None,
    temperature: float = TEMPERATURE,
    budget: Budget | None = None,
) -> Objective:
    """`objective` of images that are prepared once, and a matcher whose disparity range is known; of at most so many
    frames."""
    data, cost = _bands(images, scale, frames, rows)
    metric_chart = count_chart(images.rig, reach, free)
    chart = metric_chart.with_unit_baseline()
    traced_chart = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), chart)

    def values(points: np.ndarray) -> np.ndarray:
        extrinsics = chart.extrinsics(points)
        return np.sum([host.counts(band, extrinsics, matcher) for band in data], axis=0, dtype=float)

    scaled, soft = matcher.scaled(scale), jnp.float32(checked_temperature(temperature))
    traced = Traced(
        count=StereoCount(data, traced_chart, scaled) if matcher.traceable else None,
        soft_count=StereoSoftCount(data, traced_chart, soft, scaled) if matcher.smooth else None,
    )
    return Objective(
        Problem(chart.dim, values, cost, traced, StereoImages(images.rig, images.pairs, metric_chart)), budget
    )


def rig_count_objective(
    images: Pyramid,
    matcher: AbstractMatcher,
    chart: RigChart,
    *,
    scale: float = 1.0,
    rows: float = 1.0,
    frames: int | None = None,
    budget: Budget | None = None,
) -> Objective:
    """`count_objective` over a box that holds intrinsics too; on the host alone, one candidate after the other."""
    data, cost = _bands(images, scale, frames, rows)

    def value(rig: StereoRig) -> int:
        extrinsics = with_unit_baseline(rig.extrinsics)[None]
        return sum(int(host.counts(band.through(rig), extrinsics, matcher)[0]) for band in data)

    def values(points: np.ndarray) -> np.ndarray:
        return np.array([value(chart.rig_at(z)) for z in points], float)

    return Objective(Problem(chart.dim, values, cost), budget)


def _bands(images: Pyramid, scale: float, frames: int | None, rows: float) -> tuple[tuple[ScoringData, ...], float]:
    """What is scored, and what a candidate costs."""
    whole = images.at(scale, frames)
    data = bands(whole, rows)
    return data, whole.cost * sum(band.pixels for band in data) / whole.pixels
