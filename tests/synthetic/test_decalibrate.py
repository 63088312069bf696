"""decalibrate: bounds, repeatability, what it leaves alone."""

import jax
import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.synthetic import decalibrate, default_rig


def test_drift_keeps_its_bounds_and_leaves_x():
    rig = default_rig()
    keys = jax.random.split(jax.random.key(0), 50)
    drifts = np.stack([decalibrate(rig, key, 2.0, 0.02).extrinsics - rig.extrinsics for key in keys])
    limits = np.array([*[np.radians(2.0)] * 3, 0.0, 0.02 * rig.baseline, 0.02 * rig.baseline])
    assert np.all(np.abs(drifts) <= limits + 1e-15)
    assert np.all(np.abs(drifts).max(0) >= 0.8 * limits)
    moving = limits > 0
    correlation = np.corrcoef(drifts[:, moving].T) - np.eye(5)
    assert np.abs(correlation).max() < 0.6


def test_drift_is_repeatable_and_float64():
    rig, key = default_rig(), jax.random.key(7)
    first, again = decalibrate(rig, key, 1.0, 0.01), decalibrate(rig, key, 1.0, 0.01)
    assert first.extrinsics.dtype == np.float64
    assert np.array_equal(first.extrinsics, again.extrinsics)
    assert first.extrinsics[3] == rig.extrinsics[3]
    assert first.left is rig.left
    assert np.array_equal(decalibrate(rig, key, 0.0, 0.0).extrinsics, rig.extrinsics)


@pytest.mark.parametrize("limits", [(-1.0, 0.01), (1.0, -0.01), (float("nan"), 0.01), (1.0, float("inf"))])
def test_limits_that_make_no_sense(limits):
    with pytest.raises(InputError, match="not negative"):
        decalibrate(default_rig(), jax.random.key(0), *limits)
