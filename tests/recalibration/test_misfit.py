"""Misfit of linear problems whose regions are spoiled in known ways."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from parts_of_repairs import Cause, misfit
from spoiled_rows import X, nothing, seen

import stereorecal as sr


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
