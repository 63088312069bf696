"""A rig with a lens, what it sees, and estimates of rigs that drifted."""

import numpy as np
import pytest
from simulated_rows import chart as chart, prior as prior, rig as rig, seen as seen

from stereorecal.estimation import estimate


@pytest.fixture(scope="session")
def looks(rig, chart, prior, seen):
    """looks(seed, degrees): a rig that a calibration left and that drifted, and the estimate of it."""

    def make(seed: int, degrees: float):
        rng = np.random.default_rng(seed)
        drift = np.r_[rng.uniform(-degrees, degrees, 5) * [1, 1, 1, 0.6, 0.6], np.zeros(chart.dim - 5)]
        true = chart.rig_at(prior.roots[len(prior.roots) // 2] @ rng.normal(0, 1, chart.dim) + drift)
        return true, estimate(seen(rig, true, seed, cells=900), rig)

    return make


@pytest.fixture(scope="session")
def drifted(looks):
    return [looks(seed, 0.5) for seed in range(5)]


@pytest.fixture(scope="session")
def hardly(looks):
    """Some of which are repaired and some are not."""
    return [looks(50 + seed, 0.06) for seed in range(5)]
