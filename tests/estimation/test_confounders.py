"""What moves rows and is no rig: shutters that roll in one camera."""

from dataclasses import replace

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.decision import Verdict, decide
from stereorecal.estimation import estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.scoring import Correspondences


def rolled(found: Correspondences, rig: sr.StereoRig, rows: float, row: float = 0.0) -> Correspondences:
    """As a shutter of the right camera shows them that rolls while the rig turns: by so many rows from the first image
    row to the last, none at `row` of the height."""
    pixels = rig.right.project(np.asarray(found.right, float))
    pixels[..., 1] += rows * (pixels[..., 1] / rig.right.size[1] - row)
    return replace(found, right=rig.right.rays(pixels).astype(np.float32))


@pytest.mark.parametrize("taken", [0.0, 0.5, 1.0])
def test_rows_move_as_the_lens_bends_them(rig, seen, taken):
    """In rectified rows a shutter's are no straight line: where the lens bends them, a pixel is more or less. By exact
    rows the truth is met to a thousandth of a degree, whichever row was taken with the other image."""
    known = estimate(rolled(seen(rig, rig, cells=900, noise=0.0), rig, 3.0, taken), rig, "exact")
    np.testing.assert_allclose(known.theta[:5], 0.0, atol=4e-4)


@pytest.mark.parametrize("rows", [1.5, 3.0])
@pytest.mark.parametrize("prior", ["default", "exact"])
def test_a_shutter_that_rolls_is_no_drift(rig, seen, rows, prior):
    """The rig is good; without a shutter that may roll it could not be told, or, by exact intrinsics, be repaired."""
    known = estimate(rolled(seen(rig, rig, cells=900), rig, rows), rig, prior)
    assert decide(known, EXTRINSICS).verdict is Verdict.GOOD
