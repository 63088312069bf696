"""Judges: what they say of a rig that is known exactly, and what they refuse."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from lenses import WIDE_LENSES
from stereorecal_boards import Board
from stereorecal_field.judges import (
    ByBoards,
    Draws,
    Judgement,
    by_boards,
    case_of,
    depth_by_truth,
    recipes_of,
    row_error_px,
    scene_with_truth,
)
from stereorecal_field.judges._distance_travelled import Travelled, depth_at, disparity_offset_px, travelled
from stereorecal_field.judges._simulated_calibration import calibrated, true_rig

import stereorecal as sr

SIZE, FOCAL, BASELINE, SHIFT = (320, 240), 300.0, 0.3, 6.0


def ideal_rig() -> sr.StereoRig:
    camera = sr.Camera(SIZE, np.array([[FOCAL, 0, 159.5], [0, FOCAL, 119.5], [0, 0, 1]]))
    return sr.StereoRig(camera, camera, np.array([0, 0, 0, -BASELINE, 0, 0]))


def turned(rig: sr.StereoRig, **degrees: float) -> sr.StereoRig:
    change = np.zeros(6)
    for axis, angle in degrees.items():
        change[("pitch", "yaw", "roll").index(axis)] = np.radians(angle)
    return rig.with_extrinsics(rig.extrinsics + change)


def lidar_scene(folder: Path, **changed) -> Path:
    """A wall at 50 baselines that an ideal rig sees, with its true disparities."""
    noise = np.random.default_rng(0).normal(size=(SIZE[1], SIZE[0] + 20))
    wall = cv2.GaussianBlur(noise, (0, 0), 1.5)
    wall = 128 + 40 * wall / wall.std()
    scene = sr.Scene(
        "wall", ideal_rig(), (sr.Pair(*(wall[:, a : a + SIZE[0]].clip(0, 255).astype(np.float32) for a in (0, 6))),)
    )
    sr.io.save_scene(scene, folder)
    np.savez(folder / "gt.npz", np.full(SIZE[::-1], SHIFT, np.float32))
    told = json.loads((folder / "calib.json").read_text()) | {
        "disparity_gt": "gt.npz",
        "gt_encoding": "npz arr_0 float32",
    }
    (folder / "calib.json").write_text(json.dumps(told | changed))
    return folder


@pytest.mark.parametrize(
    ("after", "worse"),
    [
        (Judgement(0.3, {10: 1.0, 30: 5.0}), False),
        (Judgement(0.349, {10: 1.0, 30: -5.9}), False),
        (Judgement(0.36, {10: 0.0, 30: 0.0}), True),
        (Judgement(0.1, {10: 0.0, 30: -6.1}), True),
        (Judgement(0.1, {10: 0.0, 30: np.inf}), True),
        (Judgement(0.1, {10: 0.0, 30: np.nan}), True),
        (Judgement(np.nan, {10: 0.0, 30: 0.0}), True),
        (Judgement(0.1), False),  # who cannot tell depth tells rows
        (Judgement(0.4), True),
    ],
)
def test_worse_by_rows_or_by_depth(after, worse):
    assert after.worse_than(Judgement(0.3, {10: 1.0, 30: 5.0})) is worse


def test_lidar_knows_the_right_rig_and_the_sign_of_a_wrong_one(tmp_path):
    scene, rig = scene_with_truth(lidar_scene(tmp_path / "wall")), ideal_rig()
    right = depth_by_truth(rig, rig, scene)
    assert right.rows_px < 0.05
    assert right.sure_px == pytest.approx(0.0, abs=1 / 16)  # a step of SGBM's: the wall is whole pixels away
    off = depth_by_truth(turned(rig, yaw=0.3), rig, scene)
    # Disparities grow by that, and what is seen seems nearer: aside by more than in the middle. SGBM begins at 96 px.
    aside = (np.arange(96, SIZE[0]) - 159.5) / FOCAL
    expected = np.radians(0.3) * FOCAL * np.median(1 + aside**2)
    assert off.corners_px == pytest.approx(expected, abs=0.05)  # of Lucas-Kanade on noise that is interpolated
    assert off.sure_px == pytest.approx(expected, abs=0.5)  # SGBM's are drawn towards whole pixels, at most to them
    assert off.depth_error_percent(30) == pytest.approx(100 * (10 / (10 + off.sure_px) - 1))
    assert off.depth_error_percent(30) < -8
    assert np.isinf(replace(off, sure_px=-11.0).depth_error_percent(30))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"disparity_gt": None}, "names no disparity_gt"),
        ({"gt_encoding": "pfm"}, "gt_encoding 'pfm' is not known; give one of"),
        ({"disparity_gt": "none.npz"}, "no true disparities"),
        ({"disparity_gt": "left.png", "gt_encoding": "npz arr_0 float32"}, "no true disparities"),
        ({"disparity_gt": "none.png", "gt_encoding": "uint16/256"}, "no grey image of true disparities"),
        ({"D_left": [-0.1, 0, 0, 0, 0]}, "stored rectified"),
        ({"T": [-0.3, 0.05, 0.0]}, "stored rectified"),
    ],
)
def test_what_is_no_truth_is_refused(tmp_path, changed, message):
    with pytest.raises(sr.InputError, match=message):
        scene_with_truth(lidar_scene(tmp_path / "wall", **changed))


def test_truth_of_another_size_or_of_nothing(tmp_path):
    folder = lidar_scene(tmp_path / "wall")
    np.savez(folder / "gt.npz", np.ones((3, 4), np.float32))
    with pytest.raises(sr.InputError, match="is not of the images' size"):
        scene_with_truth(folder)
    np.savez(folder / "gt.npz", np.full(SIZE[::-1], np.nan, np.float32))
    with pytest.raises(sr.InputError, match="fewer than 200 pixels"):
        scene_with_truth(folder)


def test_boards_know_the_right_rig_and_the_length_of_squares():
    rig, draw = sr.synthetic.default_rig(), np.random.default_rng(0)
    flat = np.stack(np.meshgrid(np.arange(6), np.arange(4)), axis=-1).reshape(-1, 2) * 0.05
    points = np.column_stack([flat, np.zeros(len(flat))])
    boards = []
    for _ in range(5):
        turn = cv2.Rodrigues(draw.uniform(-0.4, 0.4, 3))[0]
        seen = points @ turn.T + [draw.uniform(-0.3, 0.1), draw.uniform(-0.2, 0.1), draw.uniform(1.2, 1.8)]
        other = seen @ rig.rotation.T + rig.translation
        ends = (c.project(s / s[:, 2:]) for c, s in ((rig.left, seen), (rig.right, other)))
        boards.append(Board(*ends, points))
    right = by_boards(rig, rig, boards)
    assert right.rows_rms_px < 1e-3
    assert abs(right.squares_percent) < 1e-3
    assert right.depth_error_percent(30) == pytest.approx(right.squares_percent * 30 / right.baselines)
    assert by_boards(turned(rig, pitch=0.1), rig, boards).rows_rms_px == pytest.approx(np.radians(0.1) * 600, rel=0.1)
    nearer = by_boards(turned(rig, yaw=0.2), rig, boards)
    assert -3.0 < nearer.squares_percent < -1.0
    assert nearer.worse_than(right)
    assert not right.worse_than(nearer)


@pytest.mark.parametrize(("baselines", "limit"), [(1.5, 0.05), (3.0, 0.1), (15.0, 0.5)])
def test_squares_are_worse_by_a_point_of_depth_at_thirty_baselines_wherever_boards_were(baselines, limit):
    stored = ByBoards(0.07, 0.0, 0.0, 0.0, baselines, 9)
    assert replace(stored, squares_percent=-1.01 * limit).worse_than(stored)
    assert not replace(stored, squares_percent=-0.99 * limit).worse_than(stored)
    assert replace(stored, rows_rms_px=0.121).worse_than(stored)


def test_distances_travelled_tell_the_offset_of_disparity():
    rig, draw = ideal_rig(), np.random.default_rng(0)
    depth = draw.uniform(2.0, 12.0, 300)
    rays = np.column_stack([draw.uniform(-0.3, 0.3, (300, 2)), np.ones(300)])
    left = rig.left.project(rays)
    right = rig.right.project((rays * depth[:, None] + rig.translation) / depth[:, None])
    seen = Travelled(left, right, depth, 1)
    assert disparity_offset_px(rig, rig, seen) == pytest.approx(0.0, abs=1e-6)
    offset = disparity_offset_px(turned(rig, yaw=0.2), rig, seen)
    assert offset == pytest.approx(np.radians(0.2) * FOCAL, rel=0.1)
    assert depth_at(offset, rig, 30) == pytest.approx(100 * (10 / (10 + offset) - 1))


def test_who_stands_still_is_not_judged_by_distances():
    pair = sr.Pair(*np.random.default_rng(0).uniform(0, 255, (2, SIZE[1], SIZE[0])).astype(np.float32))
    with pytest.raises(sr.InputError, match="0 points have a depth by the distance travelled"):
        travelled(ideal_rig(), [pair, pair], np.zeros((2, 3)))


def test_a_simulated_calibration_is_near_and_not_exact():
    true = true_rig(3)
    found = calibrated(true, 3)
    wrong = sr.difference(found, true)
    assert 0.001 < wrong.row_error_median < 0.5
    assert abs(wrong.depth_error_percent[10]) < 2.0
    assert not wrong.same_intrinsics
    assert sr.difference(true_rig(4), true).same_intrinsics is False


def test_a_simulated_calibration_is_the_same_wherever_it_is_made():
    """To the bit in one thread; OpenCV's threads add up in any order, which its solver enlarges: 1e-9 rad is less than
    a millionth of a pixel."""
    threads = cv2.getNumThreads()
    try:
        cv2.setNumThreads(1)
        one, again = (calibrated(true_rig(3), 3).extrinsics for _ in range(2))
    finally:
        cv2.setNumThreads(threads)
    np.testing.assert_array_equal(one, again)
    np.testing.assert_allclose(calibrated(true_rig(3), 3).extrinsics, one, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("lider", "unknown judge 'lider'; did you mean lidar"),
        ("lidar", "judge lidar needs a folder; give lidar=FOLDER"),
        ("walk=there", "takes no folder"),
        ("rendered=harbor", "unknown kind of scene 'harbor'; did you mean harbour"),
        ("product=nowhere", "there is no such folder"),
    ],
)
def test_judges_that_are_none(asked, message):
    with pytest.raises(sr.InputError, match=message):
        recipes_of(asked, Draws())


def test_folders_that_do_not_hold_what_a_judge_needs(tmp_path):
    (tmp_path / "empty").mkdir()
    scene = lidar_scene(tmp_path / "scenes" / "one", disparity_gt=None)
    for asked, message in (
        (f"lidar={tmp_path / 'empty'}", "there is no scene folder"),
        (f"lidar={scene}", "no scene names a disparity_gt"),
        (f"product={scene.parent}", "a product needs 3 scenes of one rig or more; 1 found"),
        (f"motion={scene}", r"poses\.txt: there is no such file"),
        (f"boards={scene.parent}", "needs --square"),
    ):
        with pytest.raises(sr.InputError, match=message):
            recipes_of(asked, Draws())
    with pytest.raises(sr.InputError, match="0 folders are called boards"):
        recipes_of(f"boards={scene.parent}", Draws(square=0.03))
    (scene / "poses.txt").write_text("1 2 3\n")
    with pytest.raises(sr.InputError, match=r"holds no pose for each of 1 pairs"):
        recipes_of(f"motion={scene}", Draws())


def wide_rig(lens=WIDE_LENSES["equidistant"]) -> sr.StereoRig:
    camera = sr.Camera(SIZE, ideal_rig().left.matrix, np.array(lens), model="equidistant")
    return sr.StereoRig(camera, camera, ideal_rig().extrinsics)


def test_wide_lenses_are_refused_before_any_method_runs(tmp_path):
    images = np.random.default_rng(0).uniform(0, 255, (2, SIZE[1], SIZE[0])).astype(np.float32)
    for name in ("boards", "a", "b", "c"):
        sr.io.save_scene(sr.Scene(name, wide_rig(), (sr.Pair(*images),)), tmp_path / name)
    for judge in ("boards", "product", "motion"):
        with pytest.raises(sr.InputError, match=r"pinhole cameras \(radtan\) only, not equidistant"):
            recipes_of(f"{judge}={tmp_path}", Draws(square=0.03))
    wide = sr.Scene("wide", wide_rig(), (sr.Pair(*images),))
    with pytest.raises(sr.InputError, match="pinhole cameras"):
        row_error_px(wide_rig(), wide_rig(), wide)
    wall = lidar_scene(tmp_path / "wall")
    sr.io.save_scene(sr.Scene("wide", wide_rig([0.0] * 4), (sr.Pair(*images),)), tmp_path / "wide")
    told, wide = (json.loads((folder / "calib.json").read_text()) for folder in (wall, tmp_path / "wide"))
    (wall / "calib.json").write_text(json.dumps(told | wide))
    with pytest.raises(sr.InputError, match="pinhole cameras"):
        recipes_of(f"lidar={wall}", Draws())


def test_cases_of_judges():
    draws = Draws(number=3, walk=100, rides=2)
    assert [recipe.draw for recipe in recipes_of("walk", draws)] == [33, 66, 99]
    assert [recipe.scene for recipe in recipes_of("motion", draws)] == ["street", "harbour"]
    assert len(recipes_of("rendered", draws)) == 6
    every = [recipe for judge in ("rendered", "simulated", "motion", "walk") for recipe in recipes_of(judge, draws)]
    assert len({recipe.key for recipe in every}) == len(every) == 14


def test_a_folder_is_judged_as_it_is_stored_and_after_a_drift(tmp_path):
    folder = lidar_scene(tmp_path / "wall")
    stored, drifted = (case_of(recipe) for recipe in recipes_of(f"lidar={folder}", Draws(number=1)))
    np.testing.assert_array_equal(stored.start.extrinsics, ideal_rig().extrinsics)
    assert stored.prior == "default"
    assert drifted.judge(drifted.start).row_error_px > 5 * stored.judge(stored.start).row_error_px


@pytest.mark.slow
def test_a_rendered_case_knows_its_truth():
    case = case_of(recipes_of("rendered=coast", Draws())[0])
    before = case.judge(case.start)
    assert before.row_error_px > 1.0
    assert before.rotation_error_deg is not None
    assert case.prior == "exact"


def test_the_offset_of_disparity_is_in_pixels_of_the_stored_camera():
    """Whatever the focal length of the view: here that of a lens which bulges."""
    camera = sr.Camera(SIZE, ideal_rig().left.matrix, np.array([-0.4, 0.2, 0.0, 0.0]))
    rig, draw = replace(ideal_rig(), left=camera, right=camera), np.random.default_rng(0)
    depth = draw.uniform(2.0, 12.0, 300)
    rays = np.column_stack([draw.uniform(-0.1, 0.1, (300, 2)), np.ones(300)])
    points = rays * depth[:, None]
    seen = Travelled(rig.left.project(points), rig.right.project(points + rig.translation), depth, 1)
    assert sr.rectification(rig).P1[0, 0] < 0.9 * FOCAL
    assert disparity_offset_px(turned(rig, yaw=0.2), rig, seen) == pytest.approx(np.radians(0.2) * FOCAL, rel=0.05)
