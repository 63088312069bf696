"""Misfit of linear problems whose regions are spoiled in known ways."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from spoiled_rows import PER_TILE, X, nothing, seen

from stereorecal.recalibration._misfit import Cause, misfit, systematic


@pytest.mark.parametrize("noise", [0.05, 0.4])
def test_noise_is_no_misfit(noise):
    found = misfit(seen(nothing, start=(0.5, 0.2, -0.3, 1.0, 0.5), noise=noise))
    assert found.rms < 0.3 * noise
    assert found.high < 0.5 * noise
    assert found.rms_before > 3.0
    assert found.sway < 0.2


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


def test_what_rows_that_grow_explain_as_well_sways():
    stretched = misfit(seen(lambda x, y: 0.8 * y))
    assert stretched.sway > 0.3 * stretched.rms_before
    turned = misfit(seen(nothing, start=(0.3, 0.0, 0.2, 0.0, 0.0)))
    assert turned.sway < 0.05 * turned.rms_before


@settings(max_examples=20)
@given(seed=st.integers(0, 99), rows=st.floats(0.0, 3.0))
def test_it_widens_and_never_narrows(seed, rows):
    found = seen(lambda x, y: rows * (x + y > 0.4), seed=seed)
    left = misfit(found)
    added = systematic(found, left)
    np.testing.assert_allclose(added, added.T, atol=1e-12)
    assert np.linalg.eigvalsh(added).min() >= -1e-12
    assert np.trace(systematic(found, left)) <= left.rms**2 * 10.0


@pytest.mark.parametrize("rows", [0.5, 1.0])
def test_intervals_admit_what_a_moved_region_does(rows):
    """A quarter of the image has moved: the true rig lies within 95 % intervals of most such cases."""
    covered, before = [], []
    for seed in range(40):
        draw = np.random.default_rng(seed)
        a, b = draw.uniform(-0.5, 0.5, 2)
        found = seen(lambda x, y, a=a, b=b: rows * ((np.abs(x - a) < 0.5) & (np.abs(y - b) < 0.5)), seed=seed)
        both = found.covariance() + systematic(found, misfit(found))
        covered.append(np.abs(found.z) < 1.96 * np.sqrt(np.diag(both)))
        before.append(np.abs(found.z) < 1.96 * np.sqrt(np.diag(found.covariance())))
    assert np.mean(covered) > 0.85
    assert np.mean(covered) > np.mean(before)


def test_nothing_to_look_at():
    found = seen(nothing).of(np.zeros(48 * PER_TILE, bool))
    left = misfit(found)
    assert (left.rms, left.high, left.rms_before, left.sway) == (0.0, 0.0, 0.0, 0.0)
    assert left.cause is Cause.REGIONS
    assert left.as_dict()["place"] == []


def test_only_what_neighbours_share_widens_the_intervals():
    """Regions that err each for itself are known to the resampling of places."""
    rng = np.random.default_rng(0)
    alone = misfit(seen(lambda x, y: 0.3 * rng.choice([-1.0, 1.0], 48)[place_of(x, y)], noise=0.02))
    lens = misfit(seen(lambda x, y: 0.6 * (x * x + y * y) * y, noise=0.02))
    assert alone.rms > 0.2
    assert alone.alike < 0.5 * alone.rms
    assert lens.alike > 0.6 * lens.rms


def place_of(x, y):
    """Which of 8 by 6 places a point lies in."""
    return (np.clip((y + 1) * 3, 0, 5).astype(int) * 8 + np.clip((x + 1) * 4, 0, 7).astype(int)).astype(int)
