"""The pure face: it composes with JAX, has derivatives, and what it cannot take it refuses in a sentence."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import stereorecal as sr
from stereorecal import InputError
from stereorecal.scoring import host

MATCHER = sr.SAD(num_disparities=32)  # for which tutorial 7 has compiled these functions
UNIT = np.array([*np.radians([1.0, 1.0, 1.0]), 0.01, 0.01, 0.01])  # a degree, and a hundredth of the baseline


@pytest.fixture(scope="module")
def candidates(truth) -> jax.Array:
    steps = np.random.default_rng(0).uniform(-0.4, 0.4, (4, 6)) * UNIT
    return jnp.asarray(truth + steps, jnp.float32)


@pytest.fixture(scope="module")
def found(data, truth) -> sr.Correspondences:
    return sr.correspondences(data, truth, MATCHER)


# --- it composes --------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_soft_counts_under_jit_and_vmap(data, candidates):
    """(Counts: test_host_and_traced.)"""
    alone = np.array([float(sr.soft_count(data, e, MATCHER)) for e in candidates])
    assert len(set(alone)) == len(alone)
    compiled = jax.jit(lambda e: sr.soft_count(data, e, MATCHER))
    np.testing.assert_allclose([compiled(e) for e in candidates], alone, rtol=1e-5)
    passed = jax.jit(lambda d, e: sr.soft_count(d, e, MATCHER))
    np.testing.assert_allclose([passed(data, e) for e in candidates], alone, rtol=1e-5)
    np.testing.assert_allclose(jax.vmap(lambda e: sr.soft_count(data, e, MATCHER))(candidates), alone, rtol=1e-5)


def test_what_the_scores_return(data, truth):
    counted, soft = sr.count(data, truth, MATCHER), sr.soft_count(data, truth, MATCHER)
    assert (counted.shape, counted.dtype) == ((), jnp.int32)
    assert (soft.shape, soft.dtype) == ((), jnp.float32)
    assert 0.25 * data.pixels < counted < data.pixels
    assert abs(soft - counted) < 0.2 * counted


@pytest.mark.parametrize("score", [sr.count, sr.soft_count])
def test_any_kind_of_numbers_will_do_for_extrinsics(data, truth, score):
    """float64 and float32, NumPy and JAX: one program, one answer; and the unit of the baseline does not matter."""
    expected = float(score(data, np.float32(truth), MATCHER))
    for extrinsics in (truth, jnp.asarray(truth, jnp.float32), truth * np.array([1, 1, 1, 1024, 1024, 1024])):
        assert float(score(data, extrinsics, MATCHER)) == expected


@pytest.mark.slow
def test_correspondences_under_jit_and_vmap(data, truth, found):
    compiled = jax.jit(lambda e: sr.correspondences(data, e, MATCHER))(jnp.asarray(truth, jnp.float32))
    several = jax.vmap(lambda e: sr.correspondences(data, e, MATCHER))(jnp.asarray([truth] * 4, jnp.float32))
    for name in ("left", "right", "weight", "tile", "focal", "scale", "independent"):
        here = np.asarray(getattr(found, name), float)
        near = np.asarray(getattr(compiled, name), float)
        assert getattr(several, name).shape == (4, *here.shape)
        # A pixel that another program rounds otherwise changes its cell.
        assert (np.abs(near - here) <= 1e-3 + 1e-3 * np.abs(here)).mean() > 0.999, name
    assert sr.correspondences(data, truth, MATCHER).found == found.found > 300


def test_they_are_those_of_the_host(data, truth, found):
    by_host = host.correspondences(data, truth, MATCHER)
    assert isinstance(by_host.left, np.ndarray)
    assert by_host.found == pytest.approx(found.found, rel=1e-3)
    rows = [np.asarray(sr.row_differences(f, truth))[np.asarray(f.weight) > 0] for f in (by_host, found)]
    assert np.median(rows[0]) == pytest.approx(np.median(rows[1]), abs=1e-3)


@pytest.mark.slow
def test_row_differences_under_jit_and_vmap(found, candidates):
    alone = np.stack([np.asarray(sr.row_differences(found, e)) for e in candidates])
    here = np.asarray(found.weight) > 0
    for values in (
        jax.vmap(lambda e: sr.row_differences(found, e))(candidates),
        jax.jit(jax.vmap(sr.row_differences, in_axes=(None, 0)))(found, candidates),
        [jax.jit(lambda e: sr.row_differences(found, e))(e) for e in candidates],
    ):
        assert np.shape(values) == alone.shape
        np.testing.assert_allclose(np.asarray(values)[:, here], alone[:, here], atol=2e-3)


# --- derivatives --------------------------------------------------------------------------------------------


def soft(data):
    return lambda e: sr.soft_count(data, e, MATCHER)


def test_the_gradient_is_that_of_finite_differences(data, truth):
    gradient, step = jax.grad(soft(data)), 5e-3
    actual, expected = [], []
    for offset in np.random.default_rng(0).uniform(-0.3, 0.3, (3, 6)):
        at = truth + offset * UNIT
        actual.append(np.asarray(gradient(jnp.asarray(at, jnp.float32))) * UNIT)
        ends = [[float(soft(data)(at + s * d)) for s in (step, -step)] for d in np.diag(UNIT)]
        expected.append(-np.diff(ends)[:, 0] / (2 * step))
    assert np.linalg.norm(np.subtract(actual, expected)) < 0.15 * np.linalg.norm(expected)  # the image is small


def test_a_longer_baseline_changes_nothing(data, candidates):
    """Only the direction of the translation counts, so the gradient along it vanishes."""
    at = candidates[2]
    gradient = np.asarray(jax.grad(soft(data))(at))
    along = np.array([0, 0, 0, *np.asarray(at)[3:]])
    assert abs(gradient @ along) < 1e-3 * np.linalg.norm(gradient)


# --- refusals -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [jax.grad, jax.value_and_grad, jax.jacrev])
@pytest.mark.parametrize("wrapped", [lambda f: f, jax.jit])
def test_data_have_no_derivative(data, truth, mode, wrapped):
    with pytest.raises(InputError, match=r"its point only; differentiate with respect to the extrinsics, and close"):
        mode(wrapped(lambda d: sr.soft_count(d, truth, MATCHER)))(data)


REFUSED = {
    "bm": (
        sr.BM(num_disparities=32),
        r"needs a matcher in JAX.*use sr\.SAD\(\.\.\.\), or sr\.score, which takes every matcher\.$",
    ),
    "no range": (sr.SAD(), r"as in sr\.SAD\(num_disparities=96\).*sr\.with_disparity_range"),
    "a typing error": ("sadd", r"unknown matcher 'sadd'; did you mean sad\?"),
    "a range wider than the image": (sr.SAD(num_disparities=170), "beyond the width of the image"),
}


@pytest.mark.parametrize("function", [sr.count, sr.soft_count, sr.correspondences])
@pytest.mark.parametrize(("matcher", "said"), REFUSED.values(), ids=REFUSED)
def test_matchers_that_cannot_serve_are_refused(data, truth, function, matcher, said):
    with pytest.raises(InputError, match=f"sr.{function.__name__} {said}" if said.startswith("needs") else said):
        function(data, truth, matcher)


@pytest.mark.parametrize("temperature", [0.0, -0.1, float("nan")])
def test_temperatures_that_make_no_sense(data, truth, temperature):
    with pytest.raises(InputError, match="temperature"):
        sr.soft_count(data, truth, MATCHER, temperature)


@pytest.mark.slow
def test_a_traced_temperature_is_taken(data, truth):
    """So that it may be lowered inside a program."""
    cooled = jax.jit(lambda t: sr.soft_count(data, truth, MATCHER, t))
    for temperature in (0.3, 0.05):
        expected = float(sr.soft_count(data, truth, MATCHER, temperature))
        assert float(cooled(temperature)) == pytest.approx(expected, rel=1e-5)


@pytest.mark.slow
def test_scaled_data_scale_the_range(small, truth):
    """The matcher is always given at full size."""
    half = sr.prepare(small.rig, small.pairs, scale=0.5)
    assert half.scale == 0.5
    assert half.left.shape == (1, 60, 80)
    pairs, own = [pair.resized((80, 60)) for pair in small.pairs], sr.view(small.rig).scaled(0.5)
    resized = sr.prepare(small.rig.resized((80, 60)), pairs, own)
    counted = [int(sr.count(data, truth, sr.SAD(num_disparities=n))) for data, n in ((half, 24), (resized, 12))]
    assert counted[0] == counted[1] > 2000


# --- the host's functions under a trace ---------------------------------------------------------------------

HOST = {
    "sr.score": (lambda rig, pairs: sr.score(rig, pairs, matcher=MATCHER), "sr.count"),
    "sr.prepare": (sr.prepare, "sr.soft_count"),
    "sr.rectify": (lambda rig, pairs: sr.rectify(rig, pairs[0]), "sr.prepare"),
    "sr.disparity": (lambda rig, pairs: sr.disparity(rig, pairs[0], matcher=MATCHER), "matcher.match"),
    "sr.objective": (lambda rig, pairs: sr.objective(rig, pairs, matcher=MATCHER), "objective.traced.count"),
    "sr.health": (lambda rig, pairs: sr.health(rig, pairs, matcher=MATCHER), "sr.row_differences"),
    "sr.recalibrate": (lambda rig, pairs: sr.recalibrate(rig, pairs, matcher=MATCHER), "sr.soft_count"),
    "sr.with_disparity_range": (lambda rig, pairs: sr.with_disparity_range(None, rig, pairs), "it before tracing"),
}


@pytest.mark.parametrize("name", HOST)
@pytest.mark.parametrize("transform", [jax.jit, jax.vmap, jax.grad, jax.jacfwd])
def test_host_functions_say_what_to_use_under_a_trace(small, name, transform):
    function, instead = HOST[name]
    at = jnp.asarray(small.rig.extrinsics, jnp.float32)
    at = at[None] if transform is jax.vmap else at
    with pytest.raises(InputError) as refusal:
        transform(lambda e: function(small.rig.with_extrinsics(e), small.pairs))(at)
    said = str(refusal.value)
    assert said.startswith(f"{name} works on the host and cannot be traced by jit, vmap or grad; use ")
    assert instead in said
    assert said.count(". ") == 0  # one sentence


def test_a_traced_view_is_refused_as_well(small):
    own = sr.view(small.rig)
    with pytest.raises(InputError, match=r"sr\.score works on the host"):
        jax.jit(lambda view: sr.score(small.rig, small.pairs, matcher=MATCHER, view=view).count)(own)
