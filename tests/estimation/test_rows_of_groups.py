"""What a search fits between matches: mean row differences of groups, and how much each counts."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal.estimation import rows_of_groups
from stereorecal.objectives import Reach, linear_residuals, row_chart


@pytest.fixture
def box(rig):
    return row_chart(rig, Reach())


def solved(found, box, at, times=3):
    for _ in range(times):
        at = linear_residuals(*rows_of_groups(found, box, at), 1e3).least
    return at


@pytest.mark.parametrize("degrees", [0.0, 0.1, 1.0])
def test_the_rig_that_saw_is_found_again(rig, box, seen, degrees):
    """Yaw and z, which rows hardly tell, less surely."""
    truth = degrees / 3.0 * np.array([0.4, -0.3, 0.5, 0.2, -0.2])
    found = seen(rig, box.rig_at(truth), noise=0.02)
    end = solved(found, box, np.zeros(5))
    np.testing.assert_allclose(end[[0, 2]], truth[[0, 2]], atol=2e-3)
    np.testing.assert_allclose(end, truth, atol=0.05)


def test_of_nothing_there_is_nothing(rig, box, seen):
    found = seen(rig, rig)
    assert rows_of_groups(replace(found, weight=0.0 * np.asarray(found.weight)), box, np.zeros(5)) is None
