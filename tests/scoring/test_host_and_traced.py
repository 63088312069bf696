"""What the host's count and the traced one may differ by, as `sr.count` states it: nothing for the same extrinsics, and
for the same point of a box what float32 makes of it."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.scoring import host

KINDS = ("harbour", "street", "coast")
REAL = {"boofcv_bumblebee2/garden01": (320, 240), "kitti2015/000001_10": None}
on_a_cpu = pytest.mark.skipif(jax.default_backend() != "cpu", reason="other devices round otherwise")


def candidates_of(rig, number=4) -> np.ndarray:
    """The rig and some a little off, (n, 6) float32."""
    steps = np.random.default_rng(0).uniform(-1, 1, (number, 6)) * [0.01, 0.01, 0.01, 0, 0.01, 0.01]
    steps[0] = 0.0
    return (with_unit_baseline(rig.extrinsics) + steps).astype(np.float32)


def check_scene(given, matcher, scale=1.0, within=True):
    """`within`: in programs of the user's own as well."""
    data, candidates = sr.prepare(given.rig, given.pairs, scale=scale), candidates_of(given.rig)
    expected = host.counts_by_tile(data, candidates, matcher).sum(axis=(1, 2))
    np.testing.assert_array_equal(host.counts(data, candidates, matcher), expected)
    assert expected[0] == sr.score(given.rig, given.pairs, matcher=matcher, scale=scale).count
    np.testing.assert_array_equal([sr.count(data, e, matcher) for e in candidates], expected)
    if within:
        closed_over = jax.jit(lambda e: sr.count(data, e, matcher))
        np.testing.assert_array_equal([closed_over(e) for e in candidates], expected)
        together = jax.vmap(lambda e: sr.count(data, e, matcher))(jnp.asarray(candidates))
        np.testing.assert_array_equal(together, expected)
    assert len(set(expected.tolist())) == len(expected)


def real(data_dir, name):
    given = sr.io.load_scene(data_dir / name, limit=1)
    if REAL[name] is None:
        return given
    pairs = tuple(pair.resized(REAL[name]) for pair in given.pairs)
    return replace(given, rig=given.rig.resized(REAL[name]), pairs=pairs)


def disparities_of(name):
    return sr.SAD(num_disparities=48 if REAL[name] else 96)


@pytest.mark.slow
@on_a_cpu
@pytest.mark.parametrize("kind", KINDS)
def test_equal_on_rendered_scenes(scene, kind):
    """A user's jit knows the cameras as constants."""
    check_scene(scene(kind, 0, (160, 120)), sr.SAD(num_disparities=24), within=kind == "harbour")


@pytest.mark.slow
@on_a_cpu
def test_equal_at_another_scale_and_with_several_frames(scene):
    check_scene(scene("street", 0, (320, 240), 2), sr.SAD(num_disparities=48), 0.5, within=False)


@pytest.mark.slow
@on_a_cpu
@pytest.mark.parametrize("name", REAL)
def test_equal_on_real_scenes(data_dir, name):
    """With lenses, as large as the rendered ones; and as large as it is."""
    check_scene(real(data_dir, name), disparities_of(name), within=REAL[name] is not None)


def check_objective(given, matcher):
    asked = sr.objective(given.rig, given.pairs, matcher=matcher)
    points = np.random.default_rng(0).uniform(-0.4, 0.4, (8, 5))
    by_host, traced = asked.batch(points), [float(asked.traced.count(jnp.asarray(p, jnp.float32))) for p in points]
    width, height = given.rig.left.size
    assert np.abs(by_host - traced).max() <= 2 + width * height / 100_000
    # What differs is the way to the extrinsics alone.
    (_, centre, slopes), unit = asked.traced.count.args[0], np.array([1.0] * 3 + [given.rig.baseline] * 3)
    single = centre + jnp.asarray(points, jnp.float32) @ slopes
    np.testing.assert_allclose(single, asked.images.chart.extrinsics(points) / unit, atol=2e-7)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", KINDS)
def test_an_objective_on_rendered_scenes(scene, kind):
    check_objective(scene(kind, 0, (320, 240)), sr.SAD(num_disparities=48))


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_an_objective_on_real_scenes(data_dir, name):
    check_objective(real(data_dir, name), disparities_of(name))
