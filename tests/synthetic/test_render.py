"""Rendered scenes: the same again, plausible pictures, images that agree with the ground truth."""

from functools import cache

import cv2
import numpy as np
import pytest

import stereorecal.geometry as geometry
from stereorecal import InputError
from stereorecal.synthetic import KINDS, default_rig, ground_truth, render

RIG = default_rig().resized((320, 240))
VIEW = geometry.view(RIG)
SOLID_KINDS = ("harbour", "coast", "street")


@cache
def truth(kind):
    return ground_truth(kind, 3, rig=RIG)


@cache
def noisy(kind):
    return render(kind, 3, rig=RIG).pairs[0]


@cache
def clean(kind):
    return render(kind, 3, rig=RIG, noise=0.0, exposure=0.0, vignetting=0.0, blur=1.0).pairs[0]


def rectified(pair):
    r1, r2 = geometry.rectifying_rotations(RIG.rotation, RIG.translation)
    cameras = ((pair.left, RIG.left, r1, VIEW.matrix_left), (pair.right, RIG.right, r2, VIEW.matrix_right))
    images = []
    for image, camera, turn, matrix in cameras:
        maps = cv2.initUndistortRectifyMap(camera.matrix, camera.distortion, turn, matrix, VIEW.size, cv2.CV_32FC1)
        images.append(cv2.remap(image, *maps, cv2.INTER_LINEAR))
    return images


def smooth(disparity, reach=5):
    """True where the disparity changes little within `reach` pixels."""
    kernel = np.ones((reach, reach), np.uint8)
    return cv2.dilate(disparity, kernel) - cv2.erode(disparity, kernel) < 1.0


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", KINDS)
def test_pictures_are_plausible(kind):
    pair = noisy(kind)
    assert pair.size == (320, 240)
    for image in (pair.left, pair.right):
        assert image.dtype == np.float32
        assert np.isfinite(image).all()
        assert image.min() >= 0
        assert image.max() <= 255
        assert np.array_equal(image, np.rint(image))
        assert 60 < image.mean() < 220
        assert 15 < image.std() < 90
        assert (image == 255).mean() < 0.05


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", ["open-sea", "street"])
def test_same_seed_same_pictures(kind):
    first = noisy(kind)
    for other in range(90, 94):  # worlds are kept, but not five
        ground_truth("open-sea", other, rig=RIG.resized((16, 12)))
    again = render(kind, 3, rig=RIG).pairs[0]
    assert np.array_equal(first.left, again.left)
    assert np.array_equal(first.right, again.right)


def test_kinds_keep_their_positions():
    """The position is part of the seed: another order would change every image of a kind."""
    assert KINDS[:4] == ("harbour", "coast", "open-sea", "street")


def test_scene_carries_the_truth():
    scene = render("open-sea", 3, rig=RIG, frames=2)
    assert scene.rig is RIG
    assert scene.reference == "truth"
    assert scene.info == {"kind": "open-sea", "seed": 3}
    assert scene.name == "open-sea-3"
    assert len(scene.pairs) == 2


@pytest.mark.slow
def test_frames_move_on():
    pairs = render("street", 3, rig=RIG, frames=2).pairs
    assert np.array_equal(pairs[0].left, noisy("street").left)
    assert np.abs(pairs[0].left - pairs[1].left).mean() > 3.0
    moved = ground_truth("street", 3, rig=RIG, frame=1)
    assert np.abs(moved.disparity - truth("street").disparity).mean() > 0.02


@pytest.mark.slow
def test_options_do_what_they_say():
    flat, rough = clean("harbour"), noisy("harbour")
    grain = rough.left - render("harbour", 3, rig=RIG, noise=0.0).pairs[0].left
    assert 1.0 < grain.std() < 3.0
    vignetted = render("harbour", 3, rig=RIG, noise=0.0, exposure=0.0, blur=1.0).pairs[0]
    assert vignetted.left[:20, :20].mean() < flat.left[:20, :20].mean()


def test_unknown_kind_names_the_known_ones():
    with pytest.raises(InputError, match=r"unknown kind of scene 'harbor'; did you mean harbour\?"):
        render("harbor", 0)
    with pytest.raises(InputError, match="'moon'; choose one of: harbour, coast, open-sea, street"):
        ground_truth("moon", 0)


def test_requests_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="at least one"):
        render("coast", 0, frames=0)
    with pytest.raises(InputError, match="not negative"):
        render("coast", -1)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", KINDS)
def test_disparity_is_in_range(kind):
    disparity = truth(kind).disparity
    assert disparity.dtype == np.float32
    assert disparity.shape == (240, 320)
    assert disparity.min() >= 0.0
    assert disparity.max() < 32.0  # 64 at full size
    assert (disparity[0] < 20.0).all()


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", SOLID_KINDS)
def test_points_look_the_same_from_both_cameras(kind):
    """An independent check: points from the disparity, projected by the unrectified cameras."""
    disparity, hidden = truth(kind).disparity.astype(float), truth(kind).occluded
    columns, rows = np.meshgrid(np.arange(320.0), np.arange(240.0))
    left_turn, _ = geometry.rectifying_rotations(RIG.rotation, RIG.translation)

    def difference(shift):
        z = VIEW.focal * RIG.baseline / np.maximum(disparity + shift, 1e-6)
        rectified_points = np.stack(
            [(columns - VIEW.centre_left) / VIEW.focal * z, (rows - VIEW.centre_row) / VIEW.focal * z, z], -1
        )
        points = rectified_points @ left_turn
        values = []
        for image, camera, moved in (
            (clean(kind).left, RIG.left, points),
            (clean(kind).right, RIG.right, points @ RIG.rotation.T + RIG.translation),
        ):
            pixels = camera.project(moved).astype(np.float32)
            values.append(cv2.remap(image, pixels[..., 0], pixels[..., 1], cv2.INTER_CUBIC))
        return np.abs(values[0] - values[1])

    left = rectified(clean(kind))[0]
    textured = cv2.GaussianBlur(np.abs(np.gradient(left, axis=1)), (0, 0), 2.0) > 3.0
    inside = np.zeros_like(hidden)
    inside[15:-15, 15:-15] = True
    chosen = inside & ~hidden & smooth(disparity) & textured & (disparity > 0.5)
    assert chosen.mean() > 0.05
    right_one = np.mean(difference(0.0)[chosen])
    assert right_one < 3.0
    for shift in (-0.5, 0.5):
        assert np.mean(difference(shift)[chosen]) > 1.15 * right_one


@pytest.mark.parametrize("kind", SOLID_KINDS)
def test_occluded_pixels_are_covered_in_the_right_view(kind):
    """Forward warp: whoever lands on the same right pixel with more disparity hides the others."""
    disparity, hidden = truth(kind).disparity, truth(kind).occluded
    columns, rows = np.meshgrid(np.arange(320), np.arange(240))
    target = np.rint(columns - disparity).astype(int)
    inside = (target >= 2) & (target < 318)
    front = np.full((240, 320), -1.0, np.float32)
    np.maximum.at(front, (rows[inside], target[inside]), disparity[inside])
    widest = cv2.dilate(front, np.ones((1, 3), np.uint8))
    narrow = cv2.erode(front, np.ones((1, 3), np.uint8))
    at = np.clip(target, 0, 319)
    covered_somewhere = widest[rows, at] > disparity + 0.4
    covered_everywhere = narrow[rows, at] > disparity + 1.0
    seen_area = inside & (columns > 40) & (columns < 290) & (rows > 20) & (rows < 220)
    assert (covered_somewhere | ~hidden)[seen_area].mean() > 0.99
    assert (hidden | ~covered_everywhere)[seen_area].mean() > 0.99
    assert covered_somewhere[seen_area & hidden].mean() > 0.8


@pytest.mark.parametrize("kind", SOLID_KINDS)
def test_block_matching_finds_the_true_disparity(kind):
    left, right = (np.rint(image).astype(np.uint8) for image in rectified(noisy(kind)))
    matcher = cv2.StereoBM.create(32, 11)
    matcher.setUniquenessRatio(15)
    found = matcher.compute(left, right).astype(float) / 16.0
    disparity = truth(kind).disparity
    valid = (found >= 0) & ~truth(kind).occluded & smooth(disparity, 11)
    assert (found >= 0).mean() > 0.3
    assert (np.abs(found - disparity) <= 1.0)[valid].mean() > 0.9
    assert abs(np.median((found - disparity)[valid & (disparity > 0)])) < 0.1
