"""Images are scaled once for each scale, however many stages and rounds look at them."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.scoring import pyramid

SIZE = (160, 120)


class Counted(sr.Pair):
    """Knows to which shares of its size it was scaled, and how often."""

    scaled: Counter

    def resized(self, size):
        self.scaled[size[0] / self.size[0]] += 1
        return super().resized(size)


@pytest.fixture
def street(scene) -> Callable[..., tuple[sr.StereoRig, list[Counted]]]:
    """street(frames): a rig, and pairs that count."""

    def make(frames: int = 1):
        given, pairs = scene("street", 0, SIZE, frames), []
        for pair in given.pairs:
            pairs.append(Counted(pair.left, pair.right, pair.name))
            object.__setattr__(pairs[-1], "scaled", Counter())
        return given.rig, pairs

    return make


def bad(rig):
    return rig.with_extrinsics(rig.extrinsics + np.radians([2.2, -0.4, 1.9, 0, 0, 0]))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("frames", [1, 6])
def test_a_default_repair(street, frames):
    """Survey, a look that is not enough, count, two epipolar stages with their rounds, surveys between them, counts at
    the end. Some look at few of the pairs; one stands for all in what is compiled ahead."""
    rig, pairs = street(frames)
    solution = sr.recalibrate(bad(rig), pairs, schedule=replace(sr.Schedule.default(), survey=False))
    assert len(solution.stages) == 3
    scales = {round(SIZE[0] * scale) / SIZE[0] for scale in (1.0, 0.8, *(stage.scale for stage in solution.stages))}
    assert set(pairs[0].scaled) == scales
    assert set(pairs[-1].scaled) <= scales
    assert set(pairs[-1].scaled.values()) == {1}
    assert max(pairs[0].scaled.values()) <= (1 if frames == 1 else 3)


def test_health_and_score(street):
    """The measured range needs the coarse scale; the score and the correspondences share one."""
    rig, (pair,) = street()
    sr.health(rig, pair)
    assert pair.scaled == {1.0: 1, 0.8: 1}


def test_a_pyramid_keeps_what_it_has_prepared(street):
    rig, pairs = street(2)
    images = pyramid(rig, pairs)
    assert images.at(0.5) is images.at(0.5)
    assert images.at(0.5, 1) is not images.at(0.5)
    assert images.at(0.5, 9) is images.at(0.5)  # there are only two
    assert images.at(0.5, 1).left.shape == (1, 60, 80)
    np.testing.assert_array_equal(images.at(0.5, 1).left[0], images.at(0.5).left[0])
    assert [pair.scaled for pair in pairs] == [{0.5: 2}, {0.5: 1}]


@pytest.mark.parametrize("scale", [0.0, 1.5, float("nan"), 0.05])
def test_scales_that_make_no_sense_are_refused_each_time(street, scale):
    images = pyramid(*street())
    for _ in range(2):
        with pytest.raises(sr.InputError, match="scale is"):
            images.at(scale)
