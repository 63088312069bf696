"""A rig with a lens, and what is seen by one rig and read by another: fixtures of the estimate and the decision."""

from collections.abc import Callable

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.estimation import Mixture, calibration_prior, rig_parameters
from stereorecal.objectives import RigChart
from stereorecal.scoring import Correspondences


@pytest.fixture(scope="session")
def rig() -> sr.StereoRig:
    matrix = np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]])
    left = sr.Camera((640, 480), matrix, np.array([-0.2, 0.05, 1e-4, -2e-4]))
    other = np.array([[503.0, 0, 324], [0, 503.0, 235], [0, 0, 1]])
    right = sr.Camera((640, 480), other, np.array([-0.21, 0.06, -3e-4, 1e-4]))
    return sr.StereoRig(left, right, np.array([0.005, -0.008, 0.004, -0.12, 0.001, -0.001]))


@pytest.fixture(scope="session")
def chart(rig: sr.StereoRig) -> RigChart:
    return rig_parameters(rig)


@pytest.fixture(scope="session")
def prior(chart: RigChart) -> Mixture:
    return calibration_prior(chart)


@pytest.fixture(scope="session")
def steps(chart: RigChart) -> np.ndarray:
    """A small change of each parameter."""
    return np.array([{"%": 1e-2, "px": 1e-2, "deg": 1e-3, "": 1e-5}[p.unit] for p in chart.parameters])


@pytest.fixture(scope="session")
def seen() -> Callable[..., Correspondences]:
    """seen(given, true, seed, frames, cells, noise, nearest): points from `nearest` to 60 baselines away in pixels of
    the true rig with an error [px], read by the cameras of the given one."""

    def make(given, true, seed=0, frames=1, cells=1200, noise=0.08, nearest=4.0) -> Correspondences:
        rng, shape = np.random.default_rng(seed), (frames, cells)
        edge = np.array(true.left.size) - 1.0
        left = rng.uniform([0.0, 0.0], edge, (*shape, 2))
        away = float(true.baseline) / rng.uniform(1 / 60, 1 / nearest, (*shape, 1))
        right = true.right.project(true.left.rays(left) * away @ true.rotation.T + true.translation)
        right = right + rng.normal(0.0, 1.0, right.shape) * noise
        good = ((right >= 0.0) & (right <= edge)).all(axis=-1)
        return Correspondences(
            given.left.rays(left).astype(np.float32),
            given.right.rays(np.where(good[..., None], right, left)).astype(np.float32),
            good.astype(np.float32),
            np.zeros(shape, np.int32),
            *(np.asarray(number, np.float32) for number in (given.left.matrix[0, 0], 1.0, 0.5)),
        )

    return make
