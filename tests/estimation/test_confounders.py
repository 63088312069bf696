"""What moves rows and is no rig: shutters that roll in one camera, and regions of all frames or of each."""

from dataclasses import replace

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.decision import Verdict, decide
from stereorecal.estimation import estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.scoring import Correspondences


def rolled(found: Correspondences, rig: sr.StereoRig, rows=0.0, columns=0.0, row=0.0) -> Correspondences:
    """As a shutter of the right camera shows them that rolls while the rig turns: by so many rows and columns from the
    first image row to the last, none at `row` of the height."""
    pixels = np.asarray(rig.right.project(np.asarray(found.right, float)))
    pixels = pixels + np.array([columns, rows]) * (pixels[..., 1:] / rig.right.size[1] - row)
    return replace(found, right=rig.right.rays(pixels).astype(np.float32))


def beside(found) -> set[int]:
    """The numbers of nuisance parameters of the hypotheses that have a say."""
    return {len(one.rows.nuisances.sizes) for one in found.hypotheses}


@pytest.mark.parametrize("taken", [0.0, 0.5, 1.0])
def test_rows_move_as_the_lens_bends_them(rig, seen, taken):
    """In rectified rows a shutter's are no straight line: where the lens bends them, a pixel is more or less. By exact
    rows the truth is met to a thousandth of a degree, whichever row was taken with the other image."""
    known = estimate(rolled(seen(rig, rig, cells=900, noise=0.0), rig, 3.0, row=taken), rig, "exact")
    np.testing.assert_allclose(known.theta[:5], 0.0, atol=4e-4)


@pytest.mark.parametrize(("rows", "columns"), [(1.5, 0.0), (3.0, 0.0), (2.0, -4.0), (0.0, 8.0)])
@pytest.mark.parametrize("prior", ["default", "exact"])
def test_a_shutter_that_rolls_evenly_has_a_hypothesis_of_its_own(rig, seen, rows, columns, prior):
    """The rig is good; without a shutter that may roll, down and across, it could not be told, or, by exact intrinsics,
    be repaired."""
    known = estimate(rolled(seen(rig, rig, cells=900), rig, rows, columns), rig, prior)
    assert beside(known) == {2}
    assert decide(known, EXTRINSICS).verdict is Verdict.GOOD
    assert (np.abs(known.theta) < 3.5 * np.sqrt(np.diag(known.posterior.covariance)) + 1e-9).all()


@pytest.mark.parametrize("drift", [0.0, 1.0])
def test_a_region_common_to_all_frames_does_not_vote_for_the_rig(rig, chart, seen, drift):
    """As behind glass: what moves in all of them no other frame outvotes."""
    truth = drift * np.r_[0.3, 0.2, -0.4, 0.2, -0.3, np.zeros(chart.dim - 5)]
    found = seen(rig, chart.rig_at(truth), frames=3)
    x, y, _ = np.moveaxis(found.left, -1, 0)
    right = np.array(found.right)
    right[..., 1] += np.float32(0.8 / 500) * ((x > 0.1) & (y > -0.1))
    clean, known = (estimate(one, rig) for one in (found, replace(found, right=right)))
    assert (beside(clean), beside(known)) == ({0}, {1})
    sigmas = np.sqrt(np.diag(known.posterior.covariance))
    assert (np.abs(known.theta - truth)[:5] < 3.5 * sigmas[:5]).all()
    assert abs(known.theta[2] - truth[2]) < 0.02  # a roll is what the region looks like
    assert decide(known, EXTRINSICS).verdict is (Verdict.REPAIR if drift else Verdict.GOOD)


@pytest.mark.parametrize("drift", [0.0, 1.0])
def test_what_moved_in_each_frame_does_not_vote_for_the_rig(rig, chart, seen, drift):
    """A ship in one, a wave in another: each has its own offset, and frames in which nothing moved have none."""
    truth = drift * np.r_[0.3, 0.2, -0.4, 0.2, -0.3, np.zeros(chart.dim - 5)]
    found = seen(rig, chart.rig_at(truth), frames=3)
    (x, y, _), right = np.moveaxis(found.left, -1, 0), np.array(found.right)
    for frame, (rows, region) in enumerate([(1.5, (x > 0.1) & (y > -0.1)), (-1.2, x < -0.2)]):
        right[frame, ..., 1] += np.float32(rows / 500) * region[frame]
    known = estimate(replace(found, right=right), rig)
    assert beside(known) == {2}
    sigmas = np.sqrt(np.diag(known.posterior.covariance))
    assert (np.abs(known.theta - truth)[:5] < 3.5 * sigmas[:5]).all()
    assert sum(known.misfit) < 0.1
    assert decide(known, EXTRINSICS).verdict is (Verdict.REPAIR if drift else Verdict.GOOD)
