"""The measured disparity range holds what is really there, also through a rig that has drifted."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stereorecal.geometry import view
from stereorecal.matching import BM, SAD
from stereorecal.scoring.host import with_disparity_range
from stereorecal.synthetic import default_rig, ground_truth

SOLID = [(kind, seed) for kind in ("harbour", "coast", "street") for seed in (0, 1, 2)]


def measured(rig, pairs, matcher=None, **options):
    return with_disparity_range(matcher or SAD(), rig, pairs, view(rig), **options).num_disparities


@cache
def nearest(kind, seed):
    """What a matcher may need to find; the very nearest pixels may be a sliver at the border."""
    rig = default_rig().resized((320, 240))
    return float(np.quantile(ground_truth(kind, seed, rig=rig).disparity, 0.999))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(("kind", "seed"), SOLID)
def test_covers_the_truth_at_the_truth(scene, kind, seed):
    given_scene = scene(kind, seed)
    found = measured(given_scene.rig, given_scene.pairs)
    assert found % 16 == 0
    assert nearest(kind, seed) < found <= 144


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(("kind", "seed"), SOLID)
@pytest.mark.parametrize("signs", [(1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
def test_covers_the_truth_after_a_drift(scene, kind, seed, signs):
    given_scene = scene(kind, seed)
    rig = given_scene.rig
    drifted = rig.with_extrinsics(rig.extrinsics + np.radians([*(2.5 * np.array(signs)), 0.0, 0.0, 0.0]))
    found = measured(drifted, given_scene.pairs)
    assert found % 16 == 0
    assert nearest(kind, seed) < found < 320


def test_what_is_given_is_kept(scene):
    """The range itself, the least disparity and all other options."""
    given_scene = scene()
    assert measured(given_scene.rig, given_scene.pairs, SAD(num_disparities=17)) == 17
    plain, lower = (measured(given_scene.rig, given_scene.pairs, SAD(min_disparity=m)) for m in (0, -32))
    assert lower == plain + 32
    given = BM(block_size=15, uniqueness_ratio=5)
    found = with_disparity_range(given, given_scene.rig, given_scene.pairs, view(given_scene.rig))
    assert found == replace(given, num_disparities=found.num_disparities)


def test_no_texture_still_gives_a_range(scene):
    given_scene = scene("open-sea", 0)
    assert 16 <= measured(given_scene.rig, given_scene.pairs) < 320
