"""Least squares on epipolar residuals: one round, with its correspondences and weights frozen."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal._pytree import register_pytree
from stereorecal.objectives._chart import Chart
from stereorecal.objectives._search_box import SearchBox
from stereorecal.scoring import Correspondences, differences_of
from stereorecal.strategies import Budget, Objective, Problem, Traced

_COST_OF_A_ROW = 1e-7  # units: some sixty operations, where a matcher run on a full-size frame takes some 10^9


@register_pytree
@dataclass(frozen=True, eq=False)
class EpipolarResiduals:
    """Residuals as a function of a point of the unit box: (k m + n,), row differences over their standard deviation,
    then the way from the centre of the box (the initial calibration) over that of the drift."""

    found: Correspondences
    root_precision: Float[AnyArray, "k m"]
    chart: Chart
    prior: Float[AnyArray, ""]

    def __call__(self, z: jax.Array) -> jax.Array:
        differences = differences_of(self.found, self.chart.extrinsics(z))
        return jnp.concatenate([(self.root_precision * differences).reshape(-1), z / self.prior])


@jax.jit
def _value(residuals: EpipolarResiduals, z: Float[jax.Array, "n"]) -> Float[jax.Array, ""]:
    return -0.5 * jnp.sum(residuals(z) ** 2)


def epipolar_objective(
    found: Correspondences, precision: Float[np.ndarray, "k m"], box: SearchBox, budget: Budget | None = None
) -> Objective:
    """The value is -½ |residuals|². An evaluation looks at the correspondences, not at the pixels, and costs little.

    Args:
        precision: weight of each squared row difference, 1 / pixels².
        box: centred on the initial calibration.
        budget: default unlimited.
    """
    chart = jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), box.chart.with_unit_baseline())
    root = np.sqrt(precision).astype(np.float32)
    residuals = jax.device_put(EpipolarResiduals(found, root, chart, np.asarray(box.prior, np.float32)))

    def values(points: np.ndarray) -> np.ndarray:
        return np.array([float(_value(residuals, p)) for p in np.asarray(points, np.float32)])

    frames, cells = found.weight.shape
    cost = frames * cells * _COST_OF_A_ROW
    return Objective(Problem(chart.dim, values, cost, Traced(residuals=residuals)), budget)
