"""Misfit of linear problems whose regions are spoiled in known ways."""

import cv2
import numpy as np
import pytest
from parts_of_repairs import Misfit, row_errors_and_misfit

import stereorecal as sr

PER_TILE, FOCAL = 20, 500.0
COLUMN, ROW = np.meshgrid(np.arange(8), np.arange(6))
X, Y = (2 * COLUMN.ravel() + 1) / 8 - 1, (2 * ROW.ravel() + 1) / 6 - 1


def seen(spoil, start=(0.0,) * 5, noise=0.1, seed=0, late=False, most=None) -> Misfit:
    """The misfit of a rig at `start` degrees and percent from true, whose rows are spoiled by spoil(x, y) pixels,
    solved; of so many correspondences at most.

    Derivatives of the rows as of a rig with a field of view of some 60 degrees: pitch, yaw, roll, y, z.
    """
    rng = np.random.default_rng(seed)
    tile = np.repeat(np.arange(48), PER_TILE)
    x, y = X[tile % 48] + rng.uniform(-0.1, 0.1, tile.size), Y[tile % 48] + rng.uniform(-0.1, 0.1, tile.size)
    near = rng.uniform(0.02, 0.15, tile.size)  # baselines over depth
    degree, percent = np.radians(1.0) * FOCAL, 0.01 * FOCAL
    u, v = 0.6 * x, 0.45 * y
    jacobian = np.stack([degree * (1 + v * v), degree * u * v, degree * u, percent * near, -percent * near * v], -1)
    target = jacobian @ np.array(start) + spoil(x, y) + rng.normal(0, noise, tile.size)
    weight = np.full(tile.size, 0.5 / noise**2)
    z = -np.linalg.solve(jacobian.T @ (weight[:, None] * jacobian) + np.eye(5), jacobian.T @ (weight * target))
    before, after = target[:most], (target + jacobian @ z)[:most]
    return row_errors_and_misfit(before, after, tile[:most], 0.5, late=late)[1]


def nothing(x, y):
    return 0.0 * x


@pytest.mark.parametrize("noise", [0.05, 0.4])
def test_noise_is_no_misfit(noise):
    found = seen(nothing, start=(0.5, 0.2, -0.3, 1.0, 0.5), noise=noise)
    assert found.rms < 0.3 * noise
    assert found.high < 0.5 * noise
    assert found.rms_before > 3.0


def test_a_moved_region_is_seen_where_it_is():
    found = seen(lambda x, y: 1.0 * (x > 0.3))
    assert 0.2 < found.rms < 0.6
    assert found.as_dict()["cause"] == "regions"
    assert found.high > 0.3
    right = X[found.place] > 0.3
    assert np.mean(found.after[right]) > np.mean(found.after[~right]) + 0.2


def test_a_late_shutter_is_the_cause_whatever_it_looks_like():
    assert seen(lambda x, y: 1.5 * y, late=True).as_dict()["cause"] == "late"


@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")
def test_nothing_to_look_at():
    left = seen(nothing, most=0)
    assert (left.rms, left.high, left.rms_before) == (0.0, 0.0, 0.0)
    assert left.as_dict()["place"] == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["harbour", "coast", "street"])
def test_a_shutter_that_rolls_replaces_no_calibration(scene, kind):
    """Its rows are bent by the lens, and no rig's: a drift that explains half of them is none."""
    true = scene(kind, 1, (640, 480))
    pair = true.pairs[0]
    height, width = pair.right.shape
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    right = cv2.remap(pair.right, x, y + 3.0 * y / height, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    assert not sr.recalibrate(true.rig, sr.Pair(pair.left, right)).accepted
