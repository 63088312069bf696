"""Misfit of linear problems whose regions are spoiled in known ways."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from parts_of_repairs import Cause, RowResiduals, misfit

import stereorecal as sr

PER_TILE, FOCAL = 20, 500.0
COLUMN, ROW = np.meshgrid(np.arange(8), np.arange(6))
X, Y = (2 * COLUMN.ravel() + 1) / 8 - 1, (2 * ROW.ravel() + 1) / 6 - 1


def seen(spoil, start=(0.0,) * 5, noise=0.1, frames=1, seed=0) -> RowResiduals:
    """A rig at `start` degrees and percent from true, whose rows are spoiled by spoil(x, y) pixels, solved.

    Derivatives of the rows as of a rig with a field of view of some 60 degrees: pitch, yaw, roll, y, z.
    """
    rng = np.random.default_rng(seed)
    tile = np.repeat(np.arange(frames * 48), PER_TILE)
    x, y = X[tile % 48] + rng.uniform(-0.1, 0.1, tile.size), Y[tile % 48] + rng.uniform(-0.1, 0.1, tile.size)
    near = rng.uniform(0.02, 0.15, tile.size)  # baselines over depth
    degree, percent = np.radians(1.0) * FOCAL, 0.01 * FOCAL
    u, v = 0.6 * x, 0.45 * y
    jacobian = np.stack([degree * (1 + v * v), degree * u * v, degree * u, percent * near, -percent * near * v], -1)
    target = jacobian @ np.array(start) + spoil(x, y) + rng.normal(0, noise, tile.size)
    weight = np.full(tile.size, 0.5 / noise**2)
    z = -np.linalg.solve(jacobian.T @ (weight[:, None] * jacobian) + np.eye(5), jacobian.T @ (weight * target))
    return RowResiduals(residual=target + jacobian @ z, start_residual=target, tile=tile, independent=0.5)


def nothing(x, y):
    return 0.0 * x


@pytest.mark.parametrize("noise", [0.05, 0.4])
def test_noise_is_no_misfit(noise):
    found = misfit(seen(nothing, start=(0.5, 0.2, -0.3, 1.0, 0.5), noise=noise))
    assert found.rms < 0.3 * noise
    assert found.high < 0.5 * noise
    assert found.rms_before > 3.0


def test_a_moved_region_is_seen_where_it_is():
    found = misfit(seen(lambda x, y: 1.0 * (x > 0.3)))
    assert 0.2 < found.rms < 0.6
    assert found.cause is Cause.REGIONS
    assert found.high > 0.3
    right = X[found.place] > 0.3
    assert np.mean(found.after[right]) > np.mean(found.after[~right]) + 0.2


@pytest.mark.parametrize(
    ("spoil", "cause"),
    [
        (lambda x, y: 1.5 * y, Cause.ROWS),
        (lambda x, y: 3.0 * y * (x * x + y * y) - 2.0 * y, Cause.RADIAL),
        (lambda x, y: 1.5 * np.sign(np.sin(7 * x) * np.sin(9 * y)), Cause.REGIONS),
    ],
)
def test_the_likely_cause(spoil, cause):
    assert misfit(seen(spoil)).cause is cause


def test_a_late_shutter_is_the_cause_whatever_it_looks_like():
    assert misfit(seen(lambda x, y: 1.5 * y), late=True).cause is Cause.LATE


def test_nothing_to_look_at():
    found, none = seen(nothing), slice(0)
    rows = {name: getattr(found, name)[none] for name in ("residual", "start_residual", "tile")}
    left = misfit(replace(found, **rows))
    assert (left.rms, left.high, left.rms_before) == (0.0, 0.0, 0.0)
    assert left.cause is Cause.REGIONS
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
