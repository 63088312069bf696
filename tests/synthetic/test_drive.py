"""Simulated drives: the truth of each frame, what is rendered by it, and what lies in the cache."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.synthetic import Knock, photographs, plan_drive


def test_the_truth_moves_as_planned():
    knock = Knock(60, (0.0, 0.5, 0.0))
    drive = plan_drive("street", 3, 200, heat=True, knocks=(knock,), late=((20, 40, 0.3),))
    turned = np.degrees(drive.extrinsics[:, :3] - drive.extrinsics[0, :3])
    assert turned[60, 1] - turned[59, 1] == pytest.approx(0.5, abs=0.002)
    assert abs(turned[-1, 0]) == pytest.approx(0.1 * 199 / 500, abs=0.005)
    assert (drive.late > 0).sum() == 20
    np.testing.assert_array_equal(drive.truth(0).extrinsics, drive.rig.extrinsics)
    calm = plan_drive("street", 3, 200)
    assert np.abs(np.degrees(calm.extrinsics[:, :3] - calm.extrinsics[0, :3])).max() < 0.01
    np.testing.assert_array_equal(plan_drive("street", 3, 200).extrinsics, calm.extrinsics)
    assert {"clear", "rain", "night"} <= set(plan_drive("harbour", 0, 1000).weather)
    assert "sea" not in plan_drive("street", 0, 1000).weather


@pytest.mark.slow
def test_pairs_are_kept_and_the_same(tmp_path: Path):
    drive = plan_drive("harbour", 4, 2)
    first = list(photographs(drive, folder=tmp_path))
    assert [pair.size for pair in first] == [(320, 240)] * 2
    (kept,) = tmp_path.iterdir()
    second = list(photographs(drive, folder=str(tmp_path)))
    np.testing.assert_array_equal(first[1].right, second[1].right)
    kept.write_bytes(kept.read_bytes()[:100])
    third = list(photographs(drive, folder=tmp_path))
    np.testing.assert_array_equal(first[1].right, third[1].right)
    assert (next(photographs(drive, 1, folder=tmp_path)).left == first[1].left).all()


def test_each_camera_has_its_own_images_and_an_empty_file_is_rendered_anew(tmp_path: Path):
    drive = plan_drive("street", 4, 1, moving=False)
    small, smaller = (replace(drive, rig=drive.rig.resized(size)) for size in ((64, 48), (32, 24)))
    (first,) = photographs(small, folder=tmp_path)
    assert first.size == (64, 48)
    (kept,) = tmp_path.iterdir()
    (other,) = photographs(smaller, folder=tmp_path)
    assert other.size == (32, 24)
    kept.write_bytes(b"")
    (again,) = photographs(small, folder=tmp_path)
    np.testing.assert_array_equal(again.left, first.left)


@pytest.mark.parametrize("wrong", [("moon", 0, 10), ("street", -1, 10), ("street", 0, 0)])
def test_drives_that_make_no_sense(wrong: tuple[str, int, int]):
    with pytest.raises(sr.InputError, match="a drive"):
        plan_drive(*wrong)
