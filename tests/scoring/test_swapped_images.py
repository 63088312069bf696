"""Images that are mixed up are refused by name; drifted rigs are not."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.geometry import StereoRig, view
from stereorecal.io import load_scene
from stereorecal.matching import SAD
from stereorecal.recalibration import health, recalibrate
from stereorecal.recordings import Pair
from stereorecal.scoring import image_quality, pyramid
from stereorecal.scoring.host import refuse_swapped_images, score, with_disparity_range
from stereorecal.synthetic import KINDS, render

MISTAKES = {
    "exchanged": (lambda left, right: (right, left), "look exchanged"),
    "mirrored": (lambda left, right: (left[:, ::-1], right[:, ::-1]), "or mirrored"),
    "right mirrored": (lambda left, right: (left, right[:, ::-1]), "one of the two images is mirrored"),
    "both upside down": (lambda left, right: (left[::-1, ::-1], right[::-1, ::-1]), "both are upside down"),
    "left upside down": (lambda left, right: (left[::-1, ::-1], right), "one of the two images is upside down"),
    "right upside down": (lambda left, right: (left, right[::-1, ::-1]), "one of the two images is upside down"),
}


def mixed(pair: Pair, mistake) -> list[Pair]:
    return [Pair(*(np.ascontiguousarray(image) for image in mistake(np.asarray(pair.left), np.asarray(pair.right))))]


@pytest.mark.slow(after=6)
@pytest.mark.parametrize("name", MISTAKES)
@pytest.mark.parametrize("kind", ["harbour", "street"])
def test_each_mistake_is_named(scene, kind, name):
    given, (mistake, said) = scene(kind, 0, (320, 240)), MISTAKES[name]
    with pytest.raises(InputError, match=said):
        score(given.rig, mixed(given.pairs[0], mistake))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", MISTAKES)
def test_each_mistake_is_named_on_real_images(data_dir: Path, name):
    given, (mistake, said) = load_scene(data_dir / "boofcv_bumblebee2/garden01"), MISTAKES[name]
    with pytest.raises(InputError, match=said):
        refuse_swapped_images(pyramid(given.rig, mixed(given.pairs[0], mistake)))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("look", [health, recalibrate])
def test_some_of_several_are_named(scene, look):
    given = [scene(kind, 0, (320, 240)) for kind in ("harbour", "street", "coast")]
    right, wrong = [one.pairs[0] for one in given], given[1].pairs[0]
    exchanged = [replace(wrong, name=name, left=wrong.right, right=wrong.left) for name in ("b", "d")]
    pairs = [right[0], exchanged[0], right[2], exchanged[1]]
    with pytest.raises(InputError, match=r"b, d \(unlike the other pairs\): near things lie on the wrong side"):
        look(given[0].rig, pairs)


def test_images_of_different_things(scene):
    one, other = scene("harbour", 0, (320, 240)), scene("street", 0, (320, 240))
    with pytest.raises(InputError, match="show different things"):
        score(one.rig, [Pair(one.pairs[0].left, other.pairs[0].right)])


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("seed", "size"), [(1, (160, 120)), (1, (320, 240)), (0, (320, 240))])
def test_no_false_alarm_however_far_off(scene, kind, seed, size):
    """A survey, which refuses what matches little wherever it looks, takes all of them."""
    given = scene(kind, seed, size)
    draw = np.random.default_rng(3)
    for _ in range(6):
        drift = np.array([*np.radians(draw.uniform(-5, 5, 3)), 0, *draw.uniform(-0.05, 0.05, 2) * given.rig.baseline])
        drifted = given.rig.with_extrinsics(given.rig.extrinsics + drift)
        refuse_swapped_images(pyramid(drifted, given.pairs))
    assert with_disparity_range(SAD(), drifted, given.pairs, view(drifted), np.radians(6.0)).num_disparities


def test_nothing_is_said_of_what_shows_nothing(scene):
    """Noise has features too, and none has a partner."""
    noise = np.random.default_rng(0)
    left, right = (np.clip(noise.normal(8, 4, (240, 320)), 0, 255).round().astype(np.float32) for _ in "lr")
    assert not image_quality(Pair(left, right)).enough
    refuse_swapped_images(pyramid(scene("street", 0, (320, 240)).rig, [Pair(left, right)]))


@pytest.mark.slow
def test_the_sun_on_waves_is_no_mistake(scene):
    """Glints are elsewhere in each image, and all that an open sea shows."""
    given, draw = scene("open-sea", 1, (640, 480)), np.random.default_rng(0)
    height, width = given.pairs[0].left.shape
    images = []
    for image in (given.pairs[0].left, given.pairs[0].right):
        spoiled = np.array(image)
        for x, y in zip(draw.integers(0, width, 400), draw.integers(height // 2, height, 400), strict=True):
            cv2.ellipse(spoiled, (int(x), int(y)), draw.integers(1, 8, 2).tolist(), 0.0, 0.0, 360.0, 255.0, -1)
        images.append(spoiled)
    refuse_swapped_images(pyramid(given.rig, [Pair(*images)]))


def test_an_inverted_rotation_is_named(scene):
    """Cameras that look at each other's side: their rotation and its inverse are farther apart than any drift."""
    given = scene("street", 0, (320, 240))
    turned = given.rig.with_extrinsics(given.rig.extrinsics + np.array([0, np.radians(6.0), 0, 0, 0, 0]))
    seen = render("street", 0, rig=turned)
    refuse_swapped_images(pyramid(turned, seen.pairs))
    inverted = StereoRig.from_rotation(turned.left, turned.right, np.asarray(turned.rotation).T, turned.translation)
    with pytest.raises(InputError, match=r"inverted \(transposed\)"):
        refuse_swapped_images(pyramid(inverted, seen.pairs))


def test_a_band_that_moved_is_not_taken_for_images_that_are_exchanged(scene):
    """It bends what features say of the rotation, not the order of near and far."""
    given = scene("street", 1, (320, 240))
    right = np.array(given.pairs[0].right)
    right[102:162] = np.roll(right, -1, axis=0)[102:162]
    seen = [Pair(np.asarray(given.pairs[0].left), right)]
    for degrees in (0.0, 2.0):
        turned = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.7, -degrees, 0.5, 0, 0, 0]))
        refuse_swapped_images(pyramid(turned, seen))
