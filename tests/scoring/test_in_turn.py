"""Candidates that share a call of one program are scored as if they had it to themselves."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.scoring import _in_turn, counts, disparities, matched, normalised, prepare
from stereorecal.scoring._in_turn import in_turn

SAD_32 = SAD(num_disparities=32)


def prepared(given_scene):
    return prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))


def sum_of(data, extrinsics, matcher):
    """Tells candidates apart without looking at an image."""
    return jnp.round(1000.0 * jnp.stack([extrinsics[0], extrinsics[1]])).astype(jnp.int32)


@pytest.mark.parametrize("number", [0, 1, 2, 31, 64, 65, 200])
def test_each_candidate_gets_its_own_answer(scene, number):
    data = prepared(scene())
    candidates = np.zeros((number, 6), np.float32)
    candidates[:, 0], candidates[:, 1] = np.arange(number), -np.arange(number)
    answers = in_turn(sum_of, data, candidates, SAD_32)
    assert answers.shape == (number, 2)
    np.testing.assert_array_equal(answers, 1000 * candidates[:, :2])


def test_one_program_serves_any_number(scene):
    data = prepared(scene())
    in_turn(sum_of, data, np.zeros((1, 6)), SAD_32)
    before = _in_turn._seen._cache_size()
    for number in (0, 2, 7, 50):
        in_turn(sum_of, data, np.zeros((number, 6)), SAD_32)
    assert _in_turn._seen._cache_size() == before


@settings(max_examples=8, deadline=None)
@given(
    kind=st.sampled_from(["harbour", "street", "coast"]),
    size=st.sampled_from([(160, 120), (200, 130)]),
    offsets=st.lists(st.tuples(*[st.floats(-0.03, 0.03)] * 3), min_size=1, max_size=12),
)
def test_counts_what_disparities_show(scene, kind, size, offsets):
    """Pixel for pixel: `score` and a search must mean the same by a count."""
    given_scene = scene(kind, 0, size)
    data = prepared(given_scene)
    candidates = np.repeat(normalised(given_scene.rig.extrinsics)[None], len(offsets), axis=0)
    candidates[:, :3] += offsets
    shown = [sum(d.valid.sum() for d in disparities(data, one.astype(np.float32), SAD_32)) for one in candidates]
    np.testing.assert_array_equal(counts(data, candidates, SAD_32), shown)
    np.testing.assert_array_equal(matched(data, candidates, SAD_32), shown)
