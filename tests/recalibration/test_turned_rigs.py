"""Rigs that stand one above the other, or with a camera upside down: the answers are those of the same rig side by
side, whose images are turned."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import stereorecal as sr
from stereorecal import InputError
from stereorecal.geometry import StereoRig, rig_as_data, rig_from_data, same_rig, turned_pixels
from stereorecal.recordings import Pair, check_pairs

each_stand = pytest.mark.parametrize("turns", [(1, 1), (3, 3), (0, 2), (2, 0)])
SIZE = (160, 120)
Turns = tuple[int, int]


@pytest.fixture
def plain(scene) -> tuple[StereoRig, Pair]:
    found = scene("street", 0, SIZE)
    return found.rig, replace(found.pairs[0], origin=None)


def standing(rig: StereoRig, pair: Pair, turns: Turns) -> tuple[StereoRig, Pair]:
    """The rig as it would be calibrated, and the images that it would take."""
    left, right = (np.rot90(image, -turn) for image, turn in zip((pair.left, pair.right), turns, strict=True))
    taken = replace(rig, turns=turns).as_taken()
    return StereoRig.from_rotation(taken.left, taken.right, taken.rotation, taken.translation), Pair(left, right)


@pytest.mark.slow(after=1)
@each_stand
def test_answers_are_the_same(plain, turns: Turns):
    (rig, pair), (other, taken) = plain, standing(*plain, turns)
    assert other.turns == (0, 0)
    assert other.side_by_side().turns == turns
    assert str(sr.score(other, taken)) == str(sr.score(rig, pair))
    for one, same in zip(sr.rectify(other, taken), sr.rectify(rig, pair), strict=True):
        np.testing.assert_allclose(one, same, atol=0.05)
    assert str(sr.difference(other, other.side_by_side())) == str(sr.difference(rig, rig))
    health, same = sr.health(other, (taken.left, taken.right)), sr.health(rig, pair)
    assert health.verdict == same.verdict
    solution = sr.recalibrate(other, taken, free="rotation")
    assert solution.rig.turns == turns
    state, _ = sr.online.step(sr.online.init(other), taken)
    assert state.initial.turns == turns
    assert state.last is not None


@each_stand
def test_maps_are_for_images_as_they_were_taken(plain, turns: Turns):
    import cv2

    other, taken = standing(*plain, turns)
    made = sr.rectification(other)
    for image, camera, rotation, projection, maps, rectified in zip(
        (taken.left, taken.right), (other.left, other.right), (made.R1, made.R2), (made.P1, made.P2), made.maps,
        sr.rectify(other, taken), strict=True,
    ):  # fmt: skip
        by_opencv = cv2.initUndistortRectifyMap(
            camera.matrix, camera.distortion, rotation, projection[:, :3], made.size, cv2.CV_32FC1
        )
        inside = maps[0] != -1.0
        for one, same in zip(maps, by_opencv, strict=True):
            np.testing.assert_allclose(one[inside], same[inside], atol=1e-3)
        remapped = cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        assert np.median(np.abs(remapped - rectified)) < 0.5
    to_left = made.R2.T @ made.R1
    np.testing.assert_allclose(to_left, other.rotation, atol=1e-9)


@each_stand
def test_pairs_are_turned_once_and_travel(plain, turns: Turns):
    other, taken = standing(*plain, turns)
    rig = other.side_by_side()
    (turned,) = check_pairs(rig, taken)
    assert check_pairs(rig, turned)[0] is turned
    np.testing.assert_array_equal(turned.as_taken().left, taken.left)
    again = pickle.loads(pickle.dumps(turned))
    assert again.turns == turned.resized((80, 60)).turns == turns
    np.testing.assert_array_equal(again.right, turned.right)
    assert same_rig(rig_from_data(rig_as_data(rig)), rig)
    for wrong, pair in ((other, taken), (plain[0], turned)):
        with pytest.raises(InputError, match="give"):
            check_pairs(wrong, pair)
    with pytest.raises(InputError, match="rolling shutter"):
        turned.read_out(0.01)


@pytest.mark.slow(after=1)
@each_stand
def test_ranges_are_at_pixels_of_images_as_they_were_taken(scene, turns: Turns):
    found = scene("street", 0, (320, 240))
    rig, pair = found.rig, replace(found.pairs[0], origin=None)
    other, taken = standing(rig, pair, turns)
    pixels = np.array([[x, y] for x in range(60, 260, 20) for y in range(80, 200, 20)], float)
    matched = []
    for one, image, back in ((rig, pair, 0), (other, taken, -turns[0])):
        moved = turned_pixels(pixels, rig.left.size, back)
        ranges = [sr.Range(0, (x, y), 20.0, along="axis") for x, y in moved]
        matched.append(str(sr.recalibrate(one, image, ranges=ranges, free="rotation").ranges))
    assert matched[0] == matched[1]
    assert "agree" in matched[0]
