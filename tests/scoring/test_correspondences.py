"""Dense correspondences of rendered scenes, whose truth is known."""

from itertools import product

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures import SAD_48
from parts_of_estimates import _means_of_cells
from scipy.ndimage import uniform_filter
from spoiled import fog

from stereorecal.geometry import rectifying_rotations, view, with_unit_baseline
from stereorecal.scoring import TILES, Correspondences, median_row_error, prepare, row_differences
from stereorecal.scoring.host import correspondences, match_radius
from stereorecal.synthetic import default_rig

FIELDS = ("left", "right", "weight", "tile")


def found_in(rig, pairs, turn=(0.0, 0.0, 0.0), own_view=None):
    extrinsics = with_unit_baseline(rig.extrinsics) + np.array([*np.radians(turn), 0.0, 0.0, 0.0])
    return correspondences(prepare(rig, pairs, own_view or view(rig)), extrinsics, SAD_48)


@pytest.fixture(scope="module")
def harbour(scene):
    return scene("harbour", 0)


@pytest.fixture(scope="module")
def found(harbour):
    return found_in(harbour.rig, harbour.pairs)


@pytest.fixture(scope="module")
def in_fog(harbour):
    return found_in(harbour.rig, [fog()])


def test_shapes_are_those_of_the_images(found, in_fog):
    """Cells of 4x4 pixels at 320x240, whatever is found in them."""
    for one in (found, in_fog):
        assert [getattr(one, name).shape for name in FIELDS] == [(1, 4800, 3), (1, 4800, 3), (1, 4800), (1, 4800)]
        assert [getattr(one, name).dtype for name in FIELDS] == [np.float32, np.float32, np.float32, np.int32]
        assert all(np.isfinite(getattr(one, name)).all() for name in FIELDS)
    assert float(found.scale) == 1.0


def test_cells_are_as_independent_as_their_windows_leave_them(found):
    """Windows of 11 pixels over white noise, averaged over cells of 4x4: each cell follows those around it."""
    windows = uniform_filter(np.random.default_rng(0).normal(size=(1200, 1600)), 11, mode="wrap")
    cells = windows.reshape(300, 4, 400, 4).mean(axis=(1, 3))
    shifts = product(range(-4, 5), repeat=2)
    follows = sum(np.mean(cells * np.roll(cells, shift, axis=(0, 1))) for shift in shifts) / np.mean(cells**2)
    assert float(found.independent) == pytest.approx(1.0 / follows, rel=0.05)


def test_weights_are_one_in_the_mean_of_those_found(found, in_fog):
    here = found.weight > 0
    assert (found.weight >= 0).all()
    assert found.found == here.sum() > 1500
    assert found.weight[here].mean() == pytest.approx(1.0, rel=1e-4)
    assert found.weight[here].std() > 0.1
    assert in_fog.found == 0
    np.testing.assert_array_equal(in_fog.weight, 0)
    assert np.isnan(median_row_error(in_fog, with_unit_baseline(np.array([0, 0, 0, -1.0, 0, 0]))))


def pixels_of(found, rig):
    """Columns and rows of the left and of the right rays in the view of the truth."""
    own = view(rig)
    sides = []
    for rays, rotation, matrix in zip(
        (found.left, found.right),
        rectifying_rotations(rig.rotation, rig.translation),
        (own.matrix_left, own.matrix_right),
        strict=True,
    ):
        seen = rays.astype(float) @ (matrix @ rotation).T
        sides.append(seen[..., :2] / seen[..., 2:])
    return sides


def test_at_the_truth_rays_meet_in_one_row(harbour, found):
    here = found.weight > 0
    differences = row_differences(found, with_unit_baseline(harbour.rig.extrinsics))
    left, right = pixels_of(found, harbour.rig)
    np.testing.assert_allclose(differences, left[..., 1] - right[..., 1], atol=1e-4)
    assert abs(np.median(differences[here])) < 0.02
    assert np.median(np.abs(differences[here])) < 0.2
    assert np.median(np.abs(differences[here])) == pytest.approx(
        median_row_error(found, with_unit_baseline(harbour.rig.extrinsics))
    )
    disparity = (left - right)[here][:, 0]
    assert disparity.min() > -1.5
    assert disparity.max() < 48
    assert disparity.std() > 2


def test_cells_lie_on_their_grid_and_tiles_count_them_in_rows(harbour, found):
    """Cell by cell from the top left; 8x6 tiles of 40x40 pixels."""
    here = found.weight[0] > 0
    x, y = pixels_of(found, harbour.rig)[0][0].T
    cell = np.arange(4800)
    inside = np.s_[here]
    assert (np.abs(x - (4 * (cell % 80) + 1.5))[inside] < 1.51).all()
    assert (np.abs(y - (4 * (cell // 80) + 1.5))[inside] < 1.51).all()
    np.testing.assert_array_equal(found.tile[0], cell // 80 // 10 * 8 + cell % 80 // 10)
    assert TILES == (8, 6)
    np.testing.assert_array_equal(np.bincount(found.tile[0]), np.full(48, 100))


def test_a_cell_is_the_weighted_mean_of_its_pixels_and_weighs_as_one_of_them():
    """However few of its pixels were found; what is left over beyond whole cells belongs to none."""
    rng, side = np.random.default_rng(0), 3
    fields = rng.normal(size=(2, 8, 10)).astype(np.float32)
    weight = (rng.uniform(0.5, 2.0, (8, 10)) * (rng.uniform(size=(8, 10)) < 0.5)).astype(np.float32)
    weight[:3, :3] = 0.0
    means, weights = (np.asarray(part) for part in _means_of_cells(jnp.asarray(fields), jnp.asarray(weight), side))
    cells = [np.s_[row : row + side, column : column + side] for row in (0, 3) for column in (0, 3, 6)]
    assert means.shape == (2, len(cells))
    for index, cell in enumerate(cells):
        here = weight[cell] > 0
        expected = weight[cell][here].mean() if here.any() else 0.0
        assert weights[index] == pytest.approx(expected, rel=1e-6)
        for field, mean in zip(fields, means[:, index], strict=True):
            expected = np.average(field[cell], weights=weight[cell]) if here.any() else 0.0
            assert mean == pytest.approx(expected, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("frames", [1, 3])
def test_matches_lie_a_cell_and_a_half_apart_at_most(frames):
    """However many frames there are: a corner farther from all matches is of something else."""
    rays, cells, one = np.zeros((frames, 4800, 3), np.float32), np.zeros((frames, 4800)), np.ones((), np.float32)
    found = Correspondences(rays, rays, cells.astype(np.float32), cells.astype(np.int32), one, one, one)
    rig = default_rig()
    width, height = rig.left.size
    assert match_radius(found, rig) == pytest.approx(1.5 * np.sqrt(width * height / 4800))
