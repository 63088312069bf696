"""Sub-pixel refinement against a plain NumPy twin, and on analytic pairs whose motion is known."""

from dataclasses import replace
from functools import cache

import jax
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import Rectified, refine
from scipy.ndimage import map_coordinates

from stereorecal.matching import Disparity

SIZE = HEIGHT, WIDTH = 72, 96
MARGIN = 16  # pixels of the frame that a window or the local contrast meets the border within
INNER = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
refined = jax.jit(refine)
Y, X = np.mgrid[:HEIGHT, :WIDTH].astype(float)


@cache
def waves(seed: int, highest: float):
    rng = np.random.default_rng(seed)
    return (*rng.uniform(-highest, highest, (2, 40)), rng.uniform(0, 2 * np.pi, 40))


def texture(x, y, seed=0, highest=0.12):
    """Grey levels about 128: a sum of waves, none of them shorter than six pixels, or of a higher frequency."""
    fx, fy, phase = waves(seed, highest)
    return 128.0 + 8.0 * np.sin(2 * np.pi * (fx * x[..., None] + fy * y[..., None]) + phase).sum(-1)


def frame(left, right) -> Rectified:
    everywhere = np.ones(SIZE, bool)
    return Rectified(left.astype(np.float32), right.astype(np.float32), everywhere, everywhere)


def moved(d: float, v: float, seed=0) -> Rectified:
    """The partner of (x, y) lies at (x - d, y + v)."""
    return frame(texture(X, Y, seed), texture(X + d, Y - v, seed))


def matched(values, valid=True) -> Disparity:
    return Disparity(
        np.broadcast_to(np.float32(values), SIZE).copy(), np.broadcast_to(np.asarray(valid, bool), SIZE).copy()
    )


# --- the twin -----------------------------------------------------------------------------------------------


def box(image, width):
    padded, out = np.pad(image, width // 2), np.zeros(image.shape)
    for i in range(width):
        for j in range(width):
            out += padded[i : i + image.shape[0], j : j + image.shape[1]]
    return out


def slow_contrast(image):
    count = box(np.ones(image.shape), 15)
    centred = image - box(image, 15) / count
    return centred / np.sqrt(box(centred**2, 15) / count + 25.0)


def slow_sample(image, x, y):
    """SciPy's cubic spline through the pixels, over a repeated border."""
    height, width = image.shape
    points = np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)
    return map_coordinates(np.pad(image, 30, mode="edge"), [p + 30 for p in points], order=3)


def slow_refine(rectified: Rectified, found: Disparity):
    """(disparity, row offset, variance, good), float64, a 2x2 system solved for each pixel."""
    left, right = slow_contrast(rectified.left.astype(float)), slow_contrast(rectified.right.astype(float))
    mask = found.valid.astype(float)
    y, x = np.mgrid[: left.shape[0], : left.shape[1]].astype(float)
    around = np.pad(left, 1, mode="edge")
    gx, gy = 0.5 * (around[1:-1, 2:] - around[1:-1, :-2]), 0.5 * (around[2:, 1:-1] - around[:-2, 1:-1])
    pixels = box(mask, 11)
    tensor = np.stack([box(mask * a * b, 11) for a, b in ((gx, gx), (gx, gy), (gx, gy), (gy, gy))], -1)
    tensor = tensor.reshape(*left.shape, 2, 2)
    damping = (1e-3 * pixels + 1e-6)[..., None]
    damped = tensor + damping[..., None] * np.eye(2)
    start = np.where(found.valid, found.values, 0.0).astype(float)
    d, v = start.copy(), np.zeros_like(start)
    for _ in range(3):
        # The warped right image grows by -gx for each pixel of disparity and by gy for each of the row.
        at_start = mask * (left - slow_sample(right, x - d, y + v) - gx * (d - start) + gy * v)
        right_side = np.stack([box(mask * gx * at_start, 11), box(mask * gy * at_start, 11)], -1)
        right_side += damping * np.stack([start - d, v], -1)
        solved = np.linalg.solve(damped, right_side[..., None])[..., 0] * [-1.0, 1.0]
        step = np.clip(solved - np.stack([d - start, v], -1), -1.0, 1.0)
        d, v, last = d + mask * step[..., 0], v + mask * step[..., 1], np.abs(step).max(-1)
    noise = box(mask * (left - slow_sample(right, x - d, y + v)) ** 2, 11) / np.maximum(pixels, 1)
    schur = tensor[..., 1, 1] - tensor[..., 0, 1] ** 2 / (tensor[..., 0, 0] + 1e-6)
    variance = np.maximum(noise, 1e-5) / np.maximum(schur, 1e-6)
    good = found.valid & (last < 0.05) & (np.abs(d - start) < 1) & (np.abs(v) < 2) & (pixels > 60.5)
    near = spread(slow_spread(found, 5) > 1.0, 15)
    return d, v, variance + 0.01 * near, good & (variance < 0.17**2)


def slow_spread(found: Disparity, width):
    """Largest less smallest valid disparity around each pixel; 0 where there is none."""
    out, (height, breadth), half = np.zeros(found.values.shape), found.values.shape, width // 2
    for y in range(height):
        for x in range(breadth):
            window = np.s_[max(0, y - half) : y + half + 1, max(0, x - half) : x + half + 1]
            seen = found.values[window][found.valid[window]]
            out[y, x] = np.ptp(seen) if seen.size else 0.0
    return out


def spread(mask, width):
    """Grown by half a window to all sides."""
    return box(mask.astype(float), width) > 0


def rough(seed: int) -> tuple[Rectified, Disparity]:
    """A slanted surface, noise, a hole in the validity and a patch whose disparity is wrong."""
    rng = np.random.default_rng(seed)
    d, v = 4.0 + 0.03 * X, 0.4 - 0.01 * Y
    left = texture(X, Y, seed) + rng.normal(0, 2, SIZE)
    right = texture(X + d, Y - v, seed) + rng.normal(0, 2, SIZE)
    valid = rng.random(SIZE) < 0.9
    valid[20:40, 30:45] = False
    values = np.rint(d)
    values[50:60, 60:75] += 5
    return frame(left, right), matched(values, valid)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("seed", range(2))
def test_twin(seed):
    rectified, found = rough(seed)
    actual = jax.tree.map(np.asarray, refined(rectified, found))
    d, v, variance, good = slow_refine(rectified, found)
    assert 0.3 < good.mean() < 0.9
    assert (actual.good != good).mean() < 2e-3  # thresholds in float32
    both = good & actual.good
    np.testing.assert_allclose(actual.disparity[both], d[both], atol=1e-3)
    np.testing.assert_allclose(actual.row[both], v[both], atol=1e-3)
    np.testing.assert_allclose(actual.variance[both], variance[both], rtol=1e-2)


# --- motions that are known ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("d", "v"), [(7.3, 0.4), (3.0, -0.8), (-2.25, -0.15), (0.0, 0.0)])
def test_a_known_motion_is_recovered(d, v):
    offsets = jax.tree.map(lambda leaf: np.asarray(leaf)[INNER], refined(moved(d, v), matched(np.rint(d))))
    good = offsets.good
    assert good.mean() > 0.8
    for found, truth in ((offsets.disparity, d), (offsets.row, v)):
        assert np.median(found[good]) == pytest.approx(truth, abs=0.01)
        assert np.median(np.abs(found[good] - truth)) < 0.03
    assert np.median(np.abs(offsets.row[good] - v)) < 0.02
    assert np.quantile(np.abs(offsets.row[good] - v), 0.95) < 0.08


def test_weak_texture_is_not_drawn_to_where_it_began():
    """Where a window hardly tells, its row is uncertain, and not nearer to none."""
    noise = np.random.default_rng(0).normal(0, 1, (2, *SIZE))
    weak = frame(texture(X, Y, 0, 0.06) + noise[0], texture(X + 6.3, Y - 0.8, 0, 0.06) + noise[1])
    offsets = jax.tree.map(lambda leaf: np.asarray(leaf)[INNER], refined(weak, matched(6)))
    good = offsets.good
    assert good.mean() > 0.5
    weight = 1.0 / (offsets.variance[good] + 1e-4)
    assert np.average(offsets.row[good], weights=weight) == pytest.approx(0.8, abs=0.01)


def test_the_variance_follows_repeated_noise():
    """Where a window says that it knows less, it scatters more, and as much as it says: what its neighbours moved by
    does not add to its own noise."""
    rng, truth = np.random.default_rng(0), moved(6.2, 0.3)
    rows, said = [], []
    for _ in range(20):
        noisy = frame(*(image + rng.normal(0, 3, SIZE) for image in (truth.left, truth.right)))
        offsets = refined(noisy, matched(6))
        rows.append(np.asarray(offsets.row)[INNER])
        said.append(np.asarray(offsets.variance)[INNER])
    scatter, said = np.std(rows, axis=0, ddof=1), np.sqrt(np.mean(said, axis=0))
    assert 0.8 < np.median(scatter) / np.median(said) < 1.25
    assert np.corrcoef(scatter.ravel(), said.ravel())[0, 1] > 0.6


@settings(max_examples=10)
@given(gain=st.floats(0.6, 1.5), level=st.floats(-60, 60))
def test_exposure_of_one_image_does_not_matter(gain, level):
    plain = moved(6.3, 0.35)
    exposed = replace(plain, right=np.float32(gain) * plain.right + np.float32(level))
    before, after = (jax.tree.map(np.asarray, refined(f, matched(6))) for f in (plain, exposed))
    good = before.good & after.good
    good[:MARGIN] = good[-MARGIN:] = good[:, :MARGIN] = good[:, -MARGIN:] = False
    assert good[INNER].mean() > 0.8
    assert np.quantile(np.abs(before.row - after.row)[good], 0.95) < 0.06
    assert abs(np.median(after.row[good]) - 0.35) < 0.01
    assert abs(np.median(after.disparity[good]) - 6.3) < 0.01


# --- who takes part -----------------------------------------------------------------------------------------


@settings(max_examples=10)
@given(seed=st.integers(0, 99), wrong=st.sampled_from([np.nan, np.inf, -1e9, 40.0]))
def test_values_of_invalid_pixels_are_never_read(seed, wrong):
    rng = np.random.default_rng(seed)
    valid = rng.random(SIZE) < 0.8
    clean = matched(6, valid)
    dirty = Disparity(np.where(valid, clean.values, np.float32(wrong)), valid)
    for a, b in zip(refined(moved(6.2, 0.2), clean), refined(moved(6.2, 0.2), dirty), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("valid", [False, True])
@pytest.mark.parametrize("kind", ["texture", "constant", "vertical stripes"])
def test_nothing_to_hold_on_to_stays_finite_and_is_not_good(kind, valid):
    images = {
        "texture": texture(X, Y),
        "constant": np.full(SIZE, 128.0),
        "vertical stripes": 128 + 90 * np.sin(X),
    }
    offsets = jax.tree.map(np.asarray, refined(frame(images[kind], images[kind]), matched(0, valid)))
    assert all(np.isfinite(field).all() for field in offsets)
    if not valid:
        assert not offsets.good.any()
        np.testing.assert_array_equal(offsets.disparity, 0)
        np.testing.assert_array_equal(offsets.row, 0)
    elif kind != "texture":  # nothing says where the row is
        assert not offsets.good[INNER].any()
