"""Swapped images are refused; drifted rigs are not."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal._errors import InputError
from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.scoring.host import score, with_disparity_range
from stereorecal.synthetic import KINDS


def exchanged(pairs):
    return [replace(pair, left=pair.right, right=pair.left) for pair in pairs]


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind in ("harbour", "street") for seed in (0, 1, 2)])
def test_swapped_images(scene, kind, seed):
    given_scene = scene(kind, seed)
    with pytest.raises(InputError, match=r"look swapped .*exchange left and right\.$"):
        score(given_scene.rig, exchanged(given_scene.pairs))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_no_false_alarm(scene, kind, seed):
    given_scene = scene(kind, seed)
    rig = given_scene.rig
    for signs in ((1, 1, 1), (1, -1, 1), (-1, 1, -1), (-1, -1, -1)):
        drift = np.array([*np.radians(2.5 * np.array(signs)), 0.0, 0.025 * rig.baseline, -0.025 * rig.baseline])
        drifted = rig.with_extrinsics(rig.extrinsics + drift)
        assert with_disparity_range(SAD(), drifted, given_scene.pairs, view(drifted)).num_disparities


@pytest.mark.parametrize("kind", KINDS)
def test_no_false_alarm_within_a_wider_reach(scene, kind):
    given_scene = scene(kind, 0)
    rig = given_scene.rig
    for sign in (1, -1):
        drifted = rig.with_extrinsics(rig.extrinsics + np.radians([4.0 * sign, 5.0 * sign, -4.0, 0.0, 0.0, 0.0]))
        assert with_disparity_range(SAD(), drifted, given_scene.pairs, view(drifted), np.radians(6.0)).num_disparities


@pytest.mark.parametrize("kind", ["harbour", "street"])
def test_swapped_images_within_a_wider_reach(scene, kind):
    given_scene = scene(kind, 0)
    with pytest.raises(InputError, match="look swapped"):
        with_disparity_range(
            SAD(), given_scene.rig, exchanged(given_scene.pairs), view(given_scene.rig), np.radians(4.5)
        )
