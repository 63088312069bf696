"""What a rig reads if rigs drawn from the posterior are the truth: exact at the posterior's mean, linear around it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._consequences import Consequences, consequences, readings_at
from stereorecal.estimation._posterior import Posterior
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import RigChart

_SAMPLES = 2000
_SEED = 0


@dataclass(frozen=True, eq=False)
class SampleReadings:
    """Rows and disparities over a view, of some rigs that may be true; always the same ones.

    Attributes:
        chart: from θ to rigs.
        posterior: of θ.
        distances: in baselines.
        view: in which rows and disparities are read; None: the rig's own.
    """

    chart: RigChart
    posterior: Posterior
    distances: tuple[float, ...]
    view: View | None

    def rows_and_nearness(
        self, used: Float[np.ndarray, "n"]
    ) -> tuple[Float[np.ndarray, "d s"], Float[np.ndarray, "s d"]]:
        """What the rig at θ = used reads: root mean squares of row errors [pixels] over the view, and relative errors
        of disparity, on average over it."""
        at_mean, nearness = readings_at(self.chart.rig_at(used), self.mean_rig, self.slopes.points, self.view)
        square = [
            np.mean(rows**2) - moved @ rows * (2.0 / len(rows)) + of_moved
            for rows, (moved, of_moved) in zip(at_mean, self._rows, strict=True)
        ]
        return np.sqrt(np.maximum(square, 0.0)), nearness - self._nearness

    @cached_property
    def samples(self) -> Float[np.ndarray, "s n"]:
        """θ of the rigs."""
        return self.posterior.samples(_SAMPLES, _SEED)

    @cached_property
    def mean_rig(self) -> StereoRig:
        """The rig at the posterior's mean."""
        return self.chart.rig_at(self.posterior.mean)

    @cached_property
    def slopes(self) -> Consequences:
        """Slopes of the readings with respect to θ, at the posterior's mean."""
        return consequences(self.chart, self.posterior.mean, self.distances, self.view)

    @cached_property
    def _rows(self) -> list[tuple[Float[np.ndarray, "s _"], Float[np.ndarray, "s"]]]:
        """At each distance: by how much rows of each sample's rig differ from those at the mean, and their mean
        squares."""
        moved = [(self.samples - self.posterior.mean) @ slopes.T for slopes in self.slopes.rows]
        return [(some, np.mean(some**2, axis=1)) for some in moved]

    @cached_property
    def _nearness(self) -> Float[np.ndarray, "s d"]:
        """By how much disparities of each sample's rig differ from those at the mean, relative to them."""
        return (self.samples - self.posterior.mean) @ self.slopes.mean_nearness.T
