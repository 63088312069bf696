"""Records what a search of the compass plug-in evaluates, batch by batch."""

import numpy as np

from stereorecal.strategies import Objective, Problem


class Watched:
    """A function over the box; remembers the batches."""

    def __init__(self, function, dim=2):
        self.batches: list[np.ndarray] = []

        def values(points):
            self.batches.append(points.copy())
            return np.array([float(function(p)) for p in points])

        self.objective = Objective(Problem(dim, values))

    def run(self, strategy, start=None):
        start = np.zeros(self.objective.dim) if start is None else np.array(start, float)
        return strategy.run(self.objective, start, 0)
