"""A second call of anything public compiles nothing and traces nothing."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import stereorecal as sr

MATCHER = sr.SAD(num_disparities=32)  # for which tutorial 7 has compiled these functions


@pytest.fixture(scope="module")
def at(truth) -> jax.Array:
    return jnp.asarray(truth, jnp.float32)


@pytest.fixture(scope="module")
def found(data, at) -> sr.Correspondences:
    return sr.correspondences(data, at, MATCHER)


def check(seen: list[str], call) -> None:
    """`call(k)` for k = 0 and 1: what is new at the second call is nothing."""
    jax.block_until_ready(call(0))
    seen.clear()
    jax.block_until_ready(call(1))
    assert seen == []


def test_the_listener_hears(compilations):
    """Else nothing here would prove anything."""
    jax.jit(lambda x: 3.25 * x)(np.float32(1.0))
    assert "traced" in compilations
    assert "compiled" in compilations


@pytest.mark.slow
def test_pinhole_lenses_share_their_programs(compilations, small, at):
    """Those of 12 coefficients have programs of their own."""
    known, matched = np.asarray(small.rig.left.distortion)[:4], {}
    for number in (4, 0, 5, 8, 12):
        lens = np.zeros(0) if number == 0 else np.pad(known, (0, number - 4))
        left, right = (sr.Camera(c.size, c.matrix, lens) for c in (small.rig.left, small.rig.right))
        seen = sr.prepare(sr.StereoRig(left, right, small.rig.extrinsics), small.pairs)
        compilations.clear()
        matched[number] = int(sr.count(seen, at, MATCHER))
        assert bool(compilations) is (number in (4, 12))
    assert matched[4] == matched[5] == matched[8] == matched[12]
    assert matched[0] != matched[4]


PURE = {
    "count": lambda data, found: lambda e: sr.count(data, e, MATCHER),
    "soft_count": lambda data, found: lambda e: sr.soft_count(data, e, MATCHER),
    "correspondences": lambda data, found: lambda e: sr.correspondences(data, e, MATCHER),
    "row_differences": lambda data, found: lambda e: sr.row_differences(found, e),
}
WAYS = {
    "plain": lambda f, at: f(at),
    "NumPy": lambda f, at: f(np.asarray(at)),
    "vmap": lambda f, at: jax.vmap(f)(jnp.stack([at] * 4)),
    "grad": lambda f, at: jax.grad(f)(at),
    "jacfwd": lambda f, at: jax.jacfwd(f)(at),
    "value_and_grad": lambda f, at: jax.value_and_grad(f)(at),
    "vmap of grad": lambda f, at: jax.vmap(jax.grad(f))(jnp.stack([at] * 4)),
    "jvp": lambda f, at: jax.jvp(f, (at,), (jnp.ones(6),)),
}
ASKED = [(name, way) for name in PURE for way in ("plain", "NumPy", "vmap")]
ASKED += [("soft_count", way) for way in list(WAYS)[3:]] + [("row_differences", "jacfwd")]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "way"), ASKED)
def test_pure_functions_and_their_derivatives(compilations, data, found, at, name, way):
    """With a new lambda at the second call, and other extrinsics."""
    points = [at, at + 1e-4]
    check(compilations, lambda k: WAYS[way](PURE[name](data, found), points[k]))


@pytest.mark.slow
def test_other_data_of_the_same_shape(compilations, scene, data, at):
    """Other images, another rig, another temperature: programs depend on the shape, the scale and the matcher."""
    other = scene("street", 1, (160, 120))
    turned = other.rig.with_extrinsics(other.rig.extrinsics + 1e-3)
    sets = [data, sr.prepare(turned, other.pairs)]

    def call(k):
        return sr.count(sets[k], at, MATCHER), sr.soft_count(sets[k], at, MATCHER, [0.1, 0.2][k])

    check(compilations, call)


@pytest.mark.slow
def test_the_objective(compilations, small):
    asked = sr.objective(small.rig, small.pairs, matcher=MATCHER)
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (2, 5))
    check(compilations, lambda k: asked.value(points[k]))
    check(compilations, lambda k: asked.batch(points + 0.1 * k))
    check(compilations, lambda k: asked.batch(points[: 2 - k]))
    single = points.astype(np.float32)
    check(compilations, lambda k: asked.traced.count(jnp.asarray(single[k])))
    check(compilations, lambda k: asked.traced.soft_count(jnp.asarray(single[k])))
    check(compilations, lambda k: jax.grad(asked.traced.soft_count)(jnp.asarray(single[k])))


@pytest.mark.slow
@pytest.mark.parametrize("matcher", ["sad", "bm"])
def test_what_looks_once(compilations, small, matcher):
    """Measuring the disparity range included, where it is not given."""
    rig, pairs = small.rig, small.pairs

    def call(k):
        score = sr.score(rig, pairs, matcher=matcher)
        sr.disparity(rig, pairs[0], matcher=matcher)
        sr.health(rig, pairs, matcher=matcher)
        return sr.rectify(rig, pairs[0])[0], score.count

    check(compilations, call)


@pytest.mark.slow
def test_what_later_stages_need_is_begun_before_they_come(scene, caplog):
    """Rectified images and refined matches, beside the search; images as small as these are never scaled down for
    them."""
    given = scene(size=(172, 120))  # of no other test: nothing of it is compiled before
    jax.config.update("jax_log_compiles", True)  # in all threads
    try:
        with caplog.at_level("WARNING"):
            sr.recalibrate(given.rig, given.pairs, matcher=MATCHER)
    finally:
        jax.config.update("jax_log_compiles", False)
    compiled = [one for one in caplog.records if one.message.startswith("Finished XLA compilation")]
    assert len([one for one in compiled if one.threadName.startswith("compile")]) == 2
    assert len(compiled) > 2
