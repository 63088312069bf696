"""The soft count: a smooth twin of the count, whose gradient is true and whose summit is the count's."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from moody import Crashing
from parts_of_estimates import _soft_area

from stereorecal.matching import BM, SAD
from stereorecal.objectives import Reach, objective
from stereorecal.scoring import count, forward_gradient, prepare, soft_count
from stereorecal.strategies import Need, NeedNotMet, run_strategy

REACH = Reach(1.0, 0.01)
value = jax.jit(lambda score, z: score(z))


def made(scene, kind="harbour"):
    given = scene(kind)
    return objective(given.rig, given.pairs, matcher=SAD(num_disparities=48), reach=REACH)


def softs(score, points) -> np.ndarray:
    return np.array([float(value(score, jnp.asarray(point, jnp.float32))) for point in points])


def batched(function):
    return lambda z: jax.vmap(jax.grad(function))(jnp.stack([0.5 * z, z]))[1]


@pytest.mark.parametrize("mode", [jax.grad, jax.jacfwd, jax.jacrev, lambda f: jax.jit(jax.grad(f)), batched])
def test_its_rule_gives_what_jax_gives(mode):
    """On a score that compiles at once; and the derivatives of another one, where that is asked for; also inside of
    other functions, and beside the value."""
    data, z = {"a": jnp.array([[0.3, -1.2], [0.7, 0.4], [-0.5, 0.9]]), "b": jnp.arange(3.0)}, jnp.array([0.2, -0.6])

    def plain(data, z):
        return jnp.sum(data["b"] * jnp.sin(data["a"] @ z))

    def stepped(data, z):
        return jnp.floor(plain(data, z))

    expected = jax.grad(plain, argnums=1)(data, z)
    for score, value in ((forward_gradient(plain), plain), (forward_gradient(stepped, plain), stepped)):
        np.testing.assert_allclose(mode(lambda q, score=score: score(data, q))(z), expected, rtol=1e-5)
        chained = mode(lambda q, score=score: jnp.exp(score(data, 2.0 * q)))(0.5 * z)
        np.testing.assert_allclose(chained, 2.0 * jnp.exp(plain(data, z)) * expected, rtol=1e-5)
        assert score(data, z) == value(data, z)
        np.testing.assert_allclose(jax.value_and_grad(score, argnums=1)(data, z)[0], plain(data, z), rtol=1e-6)


@pytest.mark.slow
def test_it_tends_to_the_count_as_the_temperature_falls(scene):
    given, matcher = scene("harbour"), SAD(num_disparities=48)
    data, truth = prepare(given.rig, given.pairs), given.rig.extrinsics
    hard = int(count(data, truth, matcher))
    distance = [abs(float(soft_count(data, truth, matcher, t)) - hard) / hard for t in (0.3, 0.1, 0.03, 0.001)]
    unrounded = 0.01  # the soft count sees images that are not rounded, so a distance remains
    assert all(later <= max(earlier, unrounded) for earlier, later in pairwise(distance))
    assert distance[0] > 0.05
    assert distance[-1] < unrounded


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["harbour", "coast", "street"])
def test_its_summit_is_the_counts(scene, kind):
    problem = made(scene, kind)
    pitch = np.arange(-12, 13)[:, None] * 0.01 * np.eye(5)[0]  # degrees: the reach is one
    counted, soft = problem.batch(pitch), softs(problem.traced.soft_count, pitch)
    plateau = pitch[counted >= 0.9995 * counted.max(), 0]  # the count is flat to its own noise here
    assert np.abs(plateau - pitch[soft.argmax(), 0]).min() <= 0.02 + 1e-9
    assert np.abs(pitch[soft.argmax(), 0]) <= 0.04
    for axis in range(1, 5):
        line = np.linspace(-0.8, 0.8, 17)[:, None] * np.eye(5)[axis]
        counted, soft = problem.batch(line), softs(problem.traced.soft_count, line)
        assert counted[soft.argmax()] >= 0.99 * counted.max()  # at this size it is noisy to 0.5 %


class Smooth(Crashing):
    needs = Need.SMOOTH


def test_opencv_matchers_have_none(scene):
    given = scene()
    opaque = objective(given.rig, given.pairs, matcher=BM(num_disparities=48))
    assert opaque.traced.soft_count is opaque.traced.count is None
    assert type(opaque.value(np.zeros(5))) is float
    with pytest.raises(NeedNotMet, match="differentiable score"):
        run_strategy(Smooth(), opaque, np.zeros(5))


def test_its_area_fades_alike_at_all_borders():
    """Half at the outermost pixels, less beyond them, and nothing where a lens shows nothing."""
    width, height = 9, 7
    columns, rows = np.meshgrid(np.arange(-2.0, width + 2), np.arange(-2.0, height + 2))
    area = np.array(_soft_area(jnp.asarray([columns, rows], jnp.float32), (width, height), 0.5))
    nowhere = (columns == -1.0) & (rows == -1.0)
    np.testing.assert_array_equal(area[nowhere], 0.0)
    area[nowhere] = area[-2, -2]
    np.testing.assert_allclose(area, area[::-1], rtol=1e-5)
    np.testing.assert_allclose(area, area[:, ::-1], rtol=1e-5)
    np.testing.assert_allclose([area[2, 6], area[5, 2]], 0.5, rtol=1e-6)
    assert area[5, 6] > 0.99
    assert area[0, 6] < 0.05
