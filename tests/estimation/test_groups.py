"""Groups of correspondences against loops over frames, places and disparities."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings, strategies as st
from parts_of_estimates import FLOOR, grouped

from stereorecal.estimation import PLACES, rig_parameters
from stereorecal.geometry import Camera, StereoRig, rectifying_rotations

COLUMNS, ROWS = 14, 9


def theta_of(chart, seed: int, size: float = 1.0) -> np.ndarray:
    sizes = {"deg": 0.5, "%": 0.5, "px": 3.0, "": 1e-3}
    draw = np.random.default_rng([seed, 1]).uniform(-size, size, chart.dim)
    return draw * [sizes[parameter.unit] for parameter in chart.parameters]


def rough(found, seed: int):
    """With outliers, weights of all sizes, and some that are missing."""
    rng = np.random.default_rng([seed, 2])
    right, shape = np.array(found.right), found.weight.shape
    right[..., 1] += np.where(rng.random(shape) < 0.1, rng.uniform(-0.01, 0.01, shape), 0.0).astype(np.float32)
    weight = found.weight * rng.uniform(0.01, 3.0, shape) * (rng.random(shape) < 0.8)
    return replace(found, right=right, weight=weight.astype(np.float32), scale=np.asarray(0.5, np.float32))


def read(rig, found, given_rig) -> np.ndarray:
    """Row differences and disparities (2, k, m) under a rig: pixels, its rays, the common plane."""
    planes = []
    turns = rectifying_rotations(rig.rotation, rig.translation)
    for side, turn in zip(("left", "right"), turns, strict=True):
        pixels = getattr(given_rig, side).project(np.asarray(getattr(found, side), float))
        turned = getattr(rig, side).rays(pixels) @ turn.T
        planes.append(turned[..., :2] / turned[..., 2:])
    return float(found.focal) * np.moveaxis(planes[0] - planes[1], -1, 0)[::-1]


def by_loops(found, chart, theta) -> dict[tuple[int, int, int], dict]:
    """Each group by its frame, place and third of the disparities."""
    rows, disparity = read(chart.rig_at(theta), found, chart.rig)
    weight, scale = np.asarray(found.weight, float), float(found.scale)
    there = weight > 0
    cuts = np.quantile(disparity[there], [1 / 3, 2 / 3])
    members: dict[tuple[int, int, int], list] = {}
    for frame, cell in zip(*np.nonzero(there), strict=True):
        x, y = chart.rig.left.project(np.asarray(found.left[frame, cell], float))
        column, row = (min(max(int(v), 0), n - 1) for v, n in ((x / 640 * COLUMNS, COLUMNS), (y / 480 * ROWS, ROWS)))
        key = (frame, row * COLUMNS + column, int((disparity[frame, cell] > cuts).sum()))
        members.setdefault(key, []).append((frame, cell))
    groups = {}
    for key, cells in members.items():
        at = tuple(np.array(cells).T)
        spread = 1.4826 * np.median(np.abs(rows[at] - np.median(rows[at]))) + 0.02
        kept = np.abs(rows[at] - np.median(rows[at])) < 3 * spread
        if (count := kept.sum()) < 4:
            continue
        mine = weight[at] * kept
        noise = spread / np.sqrt(max(count * float(found.independent), 1.0)) / scale
        texture = min(1.0, max(mine.sum() / count, 0.05) / max(np.median(weight[there]), 0.05))
        groups[key] = {
            "row": mine @ rows[at] / mine.sum() / scale,
            "disparity": mine @ disparity[at] / mine.sum() / scale,
            "left": mine @ np.asarray(found.left, float)[at] / mine.sum(),
            "right": mine @ np.asarray(found.right, float)[at] / mine.sum(),
            "deviation": np.sqrt(noise**2 + FLOOR**2 / texture),
            "count": count,
        }
    return groups


@settings(max_examples=8)
@given(seed=st.integers(0, 999), frames=st.integers(1, 3), cells=st.sampled_from([900, 1500]), lenses=st.booleans())
def test_loops_say_the_same(rig, chart, seen, seed, frames, cells, lenses):
    assert PLACES == (COLUMNS, ROWS)
    theta = theta_of(chart, seed) * (lenses or np.arange(chart.dim) < 5)
    found = rough(seen(rig, chart.rig_at(theta_of(chart, seed + 1)), seed, frames, cells), seed)
    groups, expected = grouped(found, chart, theta), by_loops(found, chart, theta)
    assert len(groups) == len(expected)
    keys = sorted(expected)
    np.testing.assert_array_equal(groups.frame, [key[0] for key in keys])
    np.testing.assert_array_equal(groups.place, [key[1] for key in keys])
    for name in ("disparity", "left", "right", "deviation", "count"):
        np.testing.assert_allclose(getattr(groups, name), [expected[key][name] for key in keys], rtol=1e-6, atol=1e-7)
    zoom = np.sqrt(np.exp((theta[chart.names.index("left.f")] + theta[chart.names.index("right.f")]) / 100))
    rows = groups.rows(chart, theta)[0]
    np.testing.assert_allclose(rows, [zoom * expected[key]["row"] for key in keys], atol=1e-6)


@settings(max_examples=10)
@given(seed=st.integers(0, 999))
def test_derivatives_of_the_rows(rig, chart, seen, steps, seed):
    """Along directions in which all parameters move, and of one parameter."""
    rng = np.random.default_rng(seed)
    groups = grouped(seen(rig, chart.rig_at(theta_of(chart, seed)), seed, 1, 600), chart, np.zeros(chart.dim))
    theta = theta_of(chart, seed + 1)
    slopes = groups.rows(chart, theta)[1].T
    for direction in (rng.uniform(-1, 1, (2, chart.dim)), np.eye(chart.dim)[[seed % chart.dim]]):
        for step in direction * steps:
            ends = [groups.rows(chart, theta + sign * step)[0] for sign in (1.0, -1.0)]
            np.testing.assert_allclose(step @ slopes, (ends[0] - ends[1]) / 2, atol=2e-6, rtol=1e-4)


@settings(max_examples=8)
@given(seed=st.integers(0, 999))
def test_rows_elsewhere_are_those_of_the_pixels_read_there(rig, chart, seen, seed):
    """Correspondences that repeat have the rays of their group; another rig reads their pixels."""
    found = seen(rig, rig, seed, 1, 60, noise=0.5)
    several = replace(
        found,
        **{name: np.repeat(getattr(found, name), 5, axis=1) for name in ("left", "right", "weight", "tile")},
    )
    groups, theta = grouped(several, chart, np.zeros(chart.dim)), theta_of(chart, seed)
    alone = groups.count == 5
    one, number = np.ones((1, len(groups))), np.zeros((1, len(groups)), np.int32)
    here = replace(found, left=groups.left[None], right=groups.right[None], weight=one, tile=number)
    zoom = np.exp(0.005 * (theta[chart.names.index("left.f")] + theta[chart.names.index("right.f")]))
    expected = zoom * read(chart.rig_at(theta), here, rig)[0, 0]
    assert alone.sum() > 20
    np.testing.assert_allclose(groups.rows(chart, theta)[0][alone], expected[alone], atol=1e-6)


def test_a_longer_focal_length_makes_no_noise_smaller(seen):
    """Pixels stay where they are: a tenth more of both focal lengths, and rows are what they were."""
    camera = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]))
    rig = StereoRig(camera, camera, np.array([0, 0, 0, -0.1, 0, 0]))
    chart = rig_parameters(rig)
    longer = np.array([100 * np.log(1.1) * name.endswith(".f") for name in chart.names])
    groups = grouped(seen(rig, rig, 2, noise=0.3), chart, np.zeros(chart.dim))
    before, after = (groups.rows(chart, theta)[0] for theta in (0 * longer, longer))
    np.testing.assert_allclose(after, before, atol=0.01 * np.abs(before).max())
    assert np.sqrt(np.mean((after / groups.deviation) ** 2)) > 0.99 * np.sqrt(np.mean((before / groups.deviation) ** 2))
