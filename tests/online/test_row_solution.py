"""Covariance and rows of linear problems, against resampling."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import RowSolution

PRIOR = np.eye(5) * 36.0  # 1 / (a sixth of the box)²: a drift of a third of the reach, in a box of two
TILES = 48
SCALES = np.array([300.0, 60.0, 150.0, 40.0, 20.0])  # pixels for a half width of the box


def solve(jacobian, target, weight) -> np.ndarray:
    """The z that minimises Σ w (target + J z)² + zᵀ P z, by least squares on stacked rows."""
    root = np.sqrt(weight)
    rows = np.concatenate([root[:, None] * jacobian, 6.0 * np.eye(5)])
    return np.linalg.lstsq(rows, -np.concatenate([root * target, np.zeros(5)]), rcond=None)[0]


def problem(seed=0, frames=1, per_tile=12, common=0.0, noise=0.2, truth=None) -> tuple[RowSolution, np.ndarray]:
    """The solution of a linear problem whose tiles have errors in common, and its rows at z = 0."""
    rng = np.random.default_rng(seed)
    tile = np.repeat(np.arange(frames * TILES), per_tile).astype(np.int32)
    jacobian = rng.normal(0, 1, (len(tile), 5)) * SCALES
    direction = np.repeat(rng.normal(0, 1, (frames * TILES, 5)), per_tile, axis=0) * SCALES
    jacobian = 0.3 * jacobian + direction  # neighbours move alike
    z = rng.uniform(-0.2, 0.2, 5) if truth is None else truth
    errors = rng.normal(0, noise, len(tile)) + np.repeat(rng.normal(0, common, frames * TILES), per_tile)
    target = errors - jacobian @ z
    weight = rng.uniform(0.5, 1.5, len(tile)) / (noise**2 + common**2)
    best = solve(jacobian, target, weight)
    found = RowSolution(
        residual=target + jacobian @ best,
        start_residual=target,
        tile=tile,
        z=best,
        jacobian=jacobian,
        weight=weight,
        curvature=weight,
        prior=1 / 6,
    )
    return found, target


# --- covariance ---------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(seed=st.integers(0, 999), common=st.floats(0, 2), per_tile=st.integers(1, 6))
def test_symmetric_and_positive_definite(seed, common, per_tile):
    covariance = problem(seed, common=common, per_tile=per_tile)[0].covariance()
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9)
    assert np.linalg.eigvalsh(covariance).min() > 0
    assert np.diag(covariance).max() < 1 / 36


@pytest.mark.parametrize("nothing", [("weight", "curvature"), ("jacobian",)])
def test_without_information_it_is_the_prior(nothing):
    found = problem()[0]
    blind = replace(found, **{name: np.zeros_like(getattr(found, name)) for name in nothing})
    np.testing.assert_allclose(blind.covariance(), np.linalg.inv(PRIOR), atol=1e-12)


def test_an_axis_that_nothing_shows_keeps_the_prior():
    found = problem()[0]
    jacobian = found.jacobian.copy()
    jacobian[:, 1] = 0.0
    covariance = replace(found, jacobian=jacobian).covariance()
    assert covariance[1, 1] == pytest.approx(1 / 36)
    np.testing.assert_allclose(covariance[1, [0, 2, 3, 4]], 0, atol=1e-12)
    assert np.diag(covariance)[[0, 2, 3, 4]].max() < 1 / 3600


@pytest.mark.parametrize("common", [0.0, 0.5])
def test_the_scatter_of_fresh_data(common):
    """The same rig seen 150 times with new errors: the solutions scatter as each of them says."""
    truth = np.array([0.1, -0.1, 0.05, 0.0, -0.15])
    found = [problem(seed, common=common, truth=truth)[0] for seed in range(150)]
    scatter = np.std([f.z - truth for f in found], axis=0)
    said = np.sqrt(np.mean([np.diag(f.covariance()) for f in found], axis=0))
    np.testing.assert_allclose(said / scatter, 1.0, atol=0.3)


def repeated(found: RowSolution, times: int) -> RowSolution:
    """The same frame several times."""
    fields = {
        name: np.concatenate([getattr(found, name)] * times)
        for name in ("jacobian", "residual", "start_residual", "weight", "curvature")
    }
    return replace(found, **fields, tile=np.concatenate([found.tile + i * TILES for i in range(times)]))


@pytest.mark.parametrize("times", [2, 8])
def test_a_frame_that_repeats_is_no_news(times):
    found, _ = problem(common=0.5)
    several = repeated(found, times)
    np.testing.assert_allclose(np.diag(several.covariance()), np.diag(found.covariance()), rtol=0.1)
    for rows in ("start_residual", "residual"):
        once, more = (one.by_place(one.medians(getattr(one, rows))) for one in (found, several))
        np.testing.assert_allclose(more, once)


@pytest.mark.parametrize("places", [6, 12])
def test_few_places_are_less_sure(places):
    """The rig's own bow, say, in every frame: the 95 % intervals still hold 95 times in a hundred."""
    truth, covered = np.array([0.1, -0.1, 0.05, 0.0, -0.15]), []
    for seed in range(150):
        found = repeated(cut(problem(seed, common=0.5, truth=truth)[0], places), 4)
        best = solve(found.jacobian, found.start_residual, found.weight)
        sigma = np.sqrt(np.diag(found.covariance()))
        covered.append(np.abs(best - truth) <= 1.96 * sigma)
    assert found.places == places
    assert 0.9 < np.mean(covered) <= 1.0


def cut(found: RowSolution, places: int) -> RowSolution:
    """Its first places alone."""
    here = found.tile < places
    names = ("jacobian", "residual", "start_residual", "weight", "curvature", "tile")
    return replace(found, **{name: getattr(found, name)[here] for name in names})


def test_frames_of_their_own_are_news():
    one, nine = (problem(common=0.5, frames=frames)[0].covariance() for frames in (1, 9))
    assert 2.0 < np.sqrt(np.diag(one) / np.diag(nine)).mean() < 4.5


def test_an_offset_that_all_rows_share_is_allowed_for():
    """No resampling sees it: 0.005 pixels, as far as they move the solution. Here, resampling sees nothing at all."""
    found = problem(common=0.5)[0]
    none = np.zeros(len(found.tile))
    curvature = np.random.default_rng(0).uniform(0, 1, len(found.tile)) * found.weight
    found = replace(found, z=np.zeros(5), residual=none, curvature=curvature, scale=0.5)
    moved = solve(found.jacobian, none + 0.01, found.curvature) - solve(found.jacobian, none, found.curvature)
    inverse = np.linalg.inv(found.normal)
    expected = inverse @ PRIOR @ inverse + np.outer(moved, moved)
    np.testing.assert_allclose(found.covariance(), expected, rtol=1e-6, atol=1e-15)


def test_one_place_says_nothing():
    found = cut(problem()[0], 1)
    np.testing.assert_allclose(found.covariance(), np.linalg.inv(PRIOR))


# --- rows ---------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(seed=st.integers(0, 999))
def test_medians_are_those_of_numpy_tile_by_tile(seed):
    rng = np.random.default_rng(seed)
    found = replace(problem()[0], tile=rng.choice(rng.integers(0, 60, 9), len(problem()[0].tile)).astype(np.int32))
    differences = rng.normal(0, 1, len(found.tile)).round(1)
    expected = [np.median(np.abs(differences[found.tile == tile])) for tile in np.unique(found.tile)]
    np.testing.assert_array_equal(found.medians(differences), expected)
