"""Matrix products of traced programs are computed to float32's precision, which a GPU does only where it is told to."""

from collections.abc import Iterator
from typing import Any

import jax
import jax.numpy as jnp
import pytest

import stereorecal as sr
from stereorecal.geometry import rectifying_maps, rectifying_rotations, rotation_from_euler, with_unit_baseline

MATCHER = sr.SAD(num_disparities=16)
HIGHEST = (jax.lax.Precision.HIGHEST,) * 2


def products(program: Any) -> Iterator[Any]:
    """Every matrix product of a program and of the programs in it."""
    for step in program.eqns:
        if step.primitive.name == "dot_general":
            yield step
        for inner in jax.tree.leaves(step.params, is_leaf=lambda value: hasattr(value, "eqns")):
            if hasattr(inner, "eqns") or hasattr(inner, "jaxpr"):
                yield from products(getattr(inner, "jaxpr", inner))


@pytest.fixture(scope="module")
def data(scene) -> sr.ScoringData:
    given = scene(size=(80, 60))
    return sr.prepare(given.rig, given.pairs)


def test_scores_and_their_gradients(scene, data):
    extrinsics = jnp.asarray(with_unit_baseline(scene(size=(80, 60)).rig.extrinsics), jnp.float32)
    for score in (
        lambda e: sr.count(data, e, MATCHER),
        lambda e: sr.soft_count(data, e, MATCHER),
        jax.grad(lambda e: sr.soft_count(data, e, MATCHER)),
        lambda e: sr.correspondences(data, e, MATCHER),
    ):
        found = list(products(jax.make_jaxpr(score)(extrinsics).jaxpr))
        assert found
        assert {step.params["precision"] for step in found} == {HIGHEST}


def test_maps_and_candidates(scene):
    given = scene(size=(80, 60))
    rig, view = given.rig, sr.geometry.view(given.rig)

    def mapped(extrinsics):
        rotations = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])
        return rectifying_maps(rig.left, rig.right, rotations, view)

    candidates = sr.objective(rig, given.pairs, matcher=MATCHER).traced
    for program, at in ((mapped, jnp.ones(6)), (candidates.count, jnp.zeros(5)), (candidates.soft_count, jnp.zeros(5))):
        found = list(products(jax.make_jaxpr(program)(at).jaxpr))
        assert len(found) >= 5
        assert {step.params["precision"] for step in found} == {HIGHEST}


def test_a_product_left_to_the_device_would_be_seen():
    (step,) = products(jax.make_jaxpr(jax.jit(lambda a: a @ a))(jnp.eye(3)).jaxpr)
    assert step.params["precision"] != HIGHEST
