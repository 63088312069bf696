"""Kinds of drift, and how probable each is before any image."""

import numpy as np
import pytest
from parts_of_estimates import SIZES, drift_sizes

KINDS, WEIGHTS = drift_sizes()


@pytest.mark.parametrize("axis", range(3))
def test_one_axis_alone_has_some_percent(axis):
    others = np.delete(KINDS[:, :3], axis, axis=1)
    larger = KINDS[:, axis] > 2 * others.max(axis=1)
    assert 0.01 < WEIGHTS[larger].sum() < 0.05
    assert WEIGHTS[larger].sum() == pytest.approx(WEIGHTS[KINDS[:, 0] > KINDS[:, 1]].sum())  # no axis is preferred
    alone = larger & (others.max(axis=1) <= SIZES[0] + 1e-12)
    assert KINDS[alone, axis].max() == 4.0
    assert {0.1, 0.5, 1.0} <= set(KINDS[alone, axis])
    assert KINDS[alone, 3:].max() < 0.003  # percent of the baseline: nothing else has moved


def test_y_and_z_go_with_what_the_axes_share():
    """0.6 of the baseline for a radian: 1.05 % for a degree."""
    shared = np.sort(KINDS[:, :3], axis=1)[:, 1]
    np.testing.assert_allclose(KINDS[:, 3:], np.outer(shared, [0.6 * 100 * np.pi / 180] * 2))
