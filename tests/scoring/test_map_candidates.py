"""Candidates that share a call of one program are scored as if they had it to themselves."""

import jax.numpy as jnp
import numpy as np
import pytest
from machine import cores
from parts_of_estimates import map_candidates

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.scoring import prepare

SAD_24 = SAD(num_disparities=24)


def prepared(given_scene):
    return prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))


def first_two(frame, extrinsics, matcher):
    """Tells candidates apart, and frames."""
    return jnp.round(1000.0 * jnp.stack([extrinsics[0], extrinsics[1], frame.left[0, 0, 0]])).astype(jnp.int32)


@pytest.fixture(params=[1, 2, 5])
def some_cores(request):
    with cores(request.param):
        yield request.param


@pytest.mark.parametrize("number", [0, 1, 2, 31, 64, 65, 200])
@pytest.mark.parametrize("frames", [1, 3])
def test_each_frame_and_candidate_gets_its_own_answer(scene, some_cores, frames, number):
    data = prepared(scene(frames=frames))
    candidates = np.zeros((number, 6), np.float32)
    candidates[:, 0], candidates[:, 1] = np.arange(number), -np.arange(number)
    answers = map_candidates(first_two, data.frames, candidates, SAD_24)
    assert answers.shape == (frames, number, 3)
    for frame, of_frame in zip(data.frames, answers, strict=True):
        np.testing.assert_array_equal(of_frame[:, :2], 1000 * candidates[:, :2])
        assert (of_frame[:, 2] == np.round(1000 * np.asarray(frame.left)[0, 0, 0])).all()


@pytest.mark.parametrize(("frames", "number"), [(1, 10), (3, 10), (3, 1), (1, 100)])
def test_all_cores_have_work(scene, some_cores, frames, number):
    sizes = []

    def keep(answers):
        sizes.append(len(answers))
        return answers

    map_candidates(first_two, prepared(scene(frames=frames)).frames, np.zeros((number, 6)), SAD_24, keep)
    assert len(sizes) >= min(some_cores, frames * number)
    assert max(sizes) - min(sizes) <= 1
    assert sum(sizes) == frames * number


def test_one_program_serves_any_number(scene, compilations):
    frames = prepared(scene()).frames
    map_candidates(first_two, frames, np.zeros((1, 6)), SAD_24)
    compilations.clear()
    for number in (0, 2, 7, 50):
        map_candidates(first_two, frames, np.zeros((number, 6)), SAD_24)
    assert compilations == []
