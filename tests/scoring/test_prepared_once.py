"""Images are scaled once for each scale, however many stages and rounds look at them."""

from collections import Counter

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.scoring import _prepare, pyramid


@pytest.fixture
def prepared(monkeypatch) -> Counter:
    """How often images were prepared, by scale and number of pairs."""
    seen, original = Counter(), _prepare._prepared

    def counted(rig, pairs, view, scale):
        seen[scale, len(pairs)] += 1
        return original(rig, pairs, view, scale)

    monkeypatch.setattr(_prepare, "_prepared", counted)
    return seen


def bad(rig):
    return rig.with_extrinsics(rig.extrinsics + np.radians([0.4, -0.2, 0.3, 0, 0, 0]))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("frames", [1, 6])
def test_a_default_repair(scene, prepared, frames):
    """Survey, count, two epipolar stages with their rounds, surveys between them, counts at the end; one pair ahead."""
    given = scene("street", 0, (160, 120), frames)
    solution = sr.recalibrate(bad(given.rig), given.pairs)
    assert len(solution.stages) == 3
    assert set(prepared.values()) == {1}
    scales = {stage.scale for stage in solution.stages} | {1.0, 128 / 160}
    assert {scale for scale, _ in prepared} == scales
    few = {(done.scale, done.stage.frames) for done in solution.stages if done.stage.frames} | {(128 / 160, 4)}
    shown = {(done.scale, 1) for done in solution.stages if done.found is not None}  # for what is compiled ahead
    assert {(s, n) for s, n in prepared if n != frames} == {(s, n) for s, n in few | shown if n < frames}


def test_a_repair_on_the_count(scene, prepared):
    given = scene("street", 0, (160, 120))
    sr.recalibrate(bad(given.rig), given.pairs, schedule="count", matcher=sr.SAD(num_disparities=24), budget=20)
    assert prepared == {(1.0, 1): 1}


def test_health_and_score(scene, prepared):
    """The measured range needs the coarse scale; the score and the correspondences share one."""
    given = scene("street", 0, (160, 120))
    sr.health(given.rig, given.pairs)
    assert prepared == {(1.0, 1): 1, (128 / 160, 1): 1}


def test_a_pyramid_keeps_what_it_has_prepared(scene, prepared):
    given = scene("street", 0, (160, 120), 2)
    images = pyramid(given.rig, given.pairs)
    assert images.at(0.5) is images.at(0.5)
    assert images.at(0.5, 1) is not images.at(0.5)
    assert images.at(0.5, 9) is images.at(0.5)  # there are only two
    assert images.at(0.5, 1).left.shape == (1, 60, 80)
    np.testing.assert_array_equal(images.at(0.5, 1).left[0], images.at(0.5).left[0])
    assert prepared == {(0.5, 2): 1, (0.5, 1): 1}


@pytest.mark.parametrize("scale", [0.0, -0.5, 1.5, float("nan"), 0.05])
def test_scales_that_make_no_sense_are_refused_each_time(scene, scale):
    given = scene("street", 0, (160, 120))
    images = pyramid(given.rig, given.pairs)
    for _ in range(2):
        with pytest.raises(sr.InputError, match="scale is"):
            images.at(scale)
