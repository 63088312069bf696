"""Covariance and held-out residuals of linear problems, against resampling and against solving again."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.recalibration import _evidence
from stereorecal.recalibration._acceptance import row_errors
from stereorecal.recalibration._evidence import Evidence

PRIOR = np.eye(5) * 36.0  # 1 / (a sixth of the box)²: a drift of a third of the reach, in a box of two
TILES = 48
SCALES = np.array([300.0, 60.0, 150.0, 40.0, 20.0])  # pixels for a half width of the box


def solve(jacobian, target, weight) -> np.ndarray:
    """The z that minimises Σ w (target + J z)² + zᵀ P z, by least squares on stacked rows."""
    root = np.sqrt(weight)
    rows = np.concatenate([root[:, None] * jacobian, 6.0 * np.eye(5)])
    return np.linalg.lstsq(rows, -np.concatenate([root * target, np.zeros(5)]), rcond=None)[0]


def problem(seed=0, frames=1, per_tile=12, common=0.0, noise=0.2, truth=None) -> tuple[Evidence, np.ndarray]:
    """Evidence at the solution of a linear problem whose tiles have errors in common, and its rows at z = 0."""
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
    return Evidence(best, jacobian, target + jacobian @ best, target, weight, weight, tile, 1 / 6), target


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


@pytest.mark.parametrize("common", [0.0, 0.5])
def test_bootstrap_over_tiles(common):
    """Whole tiles drawn with replacement, and each draw solved again."""
    found, target = problem(common=common)
    rng, solutions = np.random.default_rng(1), []
    rows = [np.flatnonzero(found.tile == t) for t in range(TILES)]
    for _ in range(400):
        drawn = np.concatenate([rows[t] for t in rng.integers(0, TILES, TILES)])
        solutions.append(solve(found.jacobian[drawn], target[drawn], found.weight[drawn]))
    ratio = np.sqrt(np.diag(found.covariance()) / np.var(solutions, axis=0))
    assert (ratio > 0.7).all()
    assert (ratio < 1.4).all()


def test_errors_in_common_count_as_what_they_are():
    """Least squares as if all rows were independent would be far too sure."""
    for common, low, high in ((0.0, 0.7, 1.4), (1.0, 2.0, 5.0)):
        found = problem(common=common)[0]
        formal = np.linalg.inv(found.jacobian.T @ (found.weight[:, None] * found.jacobian) + PRIOR)
        ratio = np.sqrt(np.diag(found.covariance()) / np.diag(formal)).mean()
        assert low < ratio < high


def repeated(found: Evidence, times: int) -> Evidence:
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
    once, more = row_errors(found), row_errors(several)
    assert more.before == pytest.approx(once.before)
    assert more.significance == pytest.approx(once.significance, rel=0.2)


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


def cut(found: Evidence, places: int) -> Evidence:
    """Its first places alone."""
    here = found.tile < places
    names = ("jacobian", "residual", "start_residual", "weight", "curvature", "tile")
    return replace(found, **{name: getattr(found, name)[here] for name in names})


def test_frames_of_their_own_are_news():
    one, nine = (problem(common=0.5, frames=frames)[0].covariance() for frames in (1, 9))
    assert 2.0 < np.sqrt(np.diag(one) / np.diag(nine)).mean() < 4.5


def test_an_offset_that_all_rows_share_is_allowed_for(monkeypatch):
    """No resampling sees it: 0.005 pixels, as far as they move the solution."""
    found = problem(common=0.5)[0]
    found = replace(found, curvature=np.random.default_rng(0).uniform(0, 1, len(found.tile)) * found.weight, scale=0.5)
    none = np.zeros(len(found.tile))
    moved = solve(found.jacobian, none + 0.01, found.curvature) - solve(found.jacobian, none, found.curvature)
    covariance = found.covariance()
    monkeypatch.setattr(_evidence, "SHARED", 0.0)
    np.testing.assert_allclose(covariance - found.covariance(), np.outer(moved, moved), rtol=1e-6, atol=1e-15)


def test_one_place_says_nothing():
    found = cut(problem()[0], 1)
    np.testing.assert_allclose(found.covariance(), np.linalg.inv(PRIOR))


# --- held out -----------------------------------------------------------------------------------------------


def folds(found: Evidence) -> np.ndarray:
    """Written out: places in a pattern that leaves no region out, the same in all frames."""
    place = found.tile % TILES
    return (place % 8 + 2 * (place // 8)) % 4


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_held_out_is_what_solving_without_the_fold_says(frames):
    found, target = problem(frames=frames, per_tile=4)
    fold, unseen = folds(found), np.full(len(target), np.nan)
    for part in np.unique(fold):
        seen = fold != part
        best = solve(found.jacobian[seen], target[seen], found.weight[seen])
        unseen[~seen] = target[~seen] + found.jacobian[~seen] @ best
    before, after = found.held_out()
    tiles = range(frames * TILES)
    np.testing.assert_allclose(before, [np.median(np.abs(target[found.tile == t])) for t in tiles], rtol=1e-12)
    np.testing.assert_allclose(after, [np.median(np.abs(unseen[found.tile == t])) for t in tiles], rtol=1e-6)


@settings(max_examples=15)
@given(tile=st.integers(0, TILES - 1), size=st.floats(50, 500))
def test_a_tile_does_not_judge_itself(tile, size):
    """Whatever happens to the rows of one tile, the solution that judges it is the same: the error shows in full."""
    _, target = problem()
    after = []
    for shift in (0.0, size):
        given_problem, _ = problem()
        moved = target + np.where(given_problem.tile == tile, shift, 0.0)
        best = solve(given_problem.jacobian, moved, given_problem.weight)
        found = replace(given_problem, z=best, residual=moved + given_problem.jacobian @ best, start_residual=moved)
        after.append(found.held_out()[1])
    assert after[1][tile] == pytest.approx(size, abs=2.0)
    assert np.abs(after[1] - after[0])[np.arange(TILES) != tile].max() > 1e-3  # the others do hear of it


def test_nor_does_its_place_in_another_frame():
    """What a tile shows in one frame, it may show in the next."""
    found, target = problem(frames=3, per_tile=4)
    moved = target + np.where(found.tile % TILES == 20, 100.0, 0.0)
    best = solve(found.jacobian, moved, found.weight)
    shifted = replace(found, z=best, residual=moved + found.jacobian @ best, start_residual=moved)
    np.testing.assert_allclose(shifted.held_out()[1][20::TILES], 100.0, atol=2.0)


def test_a_true_repair_is_seen_and_a_fit_to_noise_is_not():
    found, _ = problem()
    before, after = found.held_out()
    assert np.median(after) < 0.3 < 5 < np.median(before)
    still, _ = problem(truth=np.zeros(5))
    before, after = still.held_out()
    assert np.mean(after) == pytest.approx(np.mean(before), abs=0.05)
    assert np.mean(after) > np.mean(np.abs(still.residual)) - 0.1


@pytest.mark.parametrize(("frames", "seen"), [(2, [0]), (5, [0, 4]), (3, [2])])
def test_frames_that_show_nothing_are_no_frames(frames, seen):
    """One frame of texture among frames of fog is judged as an only frame is."""
    found, _ = problem(frames=frames, per_tile=6)
    here = np.isin(found.tile // TILES, seen)
    cut = {
        name: getattr(found, name)[here]
        for name in ("jacobian", "residual", "start_residual", "weight", "curvature", "tile")
    }
    best = solve(cut["jacobian"], cut["start_residual"], cut["weight"])
    cut |= {"z": best, "residual": cut["start_residual"] + cut["jacobian"] @ best}
    before, after = replace(found, **cut).held_out()
    assert len(before) == len(after) == len(seen) * TILES
    assert np.median(after) < 0.3 < 5 < np.median(before)


@settings(max_examples=25)
@given(seed=st.integers(0, 999))
def test_medians_are_those_of_numpy_tile_by_tile(seed):
    rng = np.random.default_rng(seed)
    found = replace(problem()[0], tile=rng.choice(rng.integers(0, 60, 9), len(problem()[0].tile)).astype(np.int32))
    differences = rng.normal(0, 1, len(found.tile)).round(1)
    expected = [np.median(np.abs(differences[found.tile == tile])) for tile in np.unique(found.tile)]
    np.testing.assert_array_equal(found.medians(differences), expected)
