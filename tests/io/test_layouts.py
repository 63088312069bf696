"""What holds for every layout of a public data set."""

from pathlib import Path

import numpy as np
import pytest
from field_trees import FIELD_TREES
from trees import TREES, refused, write_image

from stereorecal import InputError
from stereorecal.io import load_log, load_scene

TREES = TREES | FIELD_TREES  # those of the distribution, too
TREE = pytest.mark.parametrize("name", TREES)


@TREE
def test_only_what_is_asked_for_is_read(tmp_path: Path, name: str):
    """With a limit of one, the first pair of each sequence is read; a limit of none is refused."""
    folder = TREES[name](tmp_path)
    everything, firsts = load_log(folder), load_log(folder, limit=1)
    assert [mission.name for mission in firsts.missions] == [mission.name for mission in everything.missions]
    for some, all_ in zip(firsts.missions, everything.missions, strict=True):
        assert [pair.name for pair in some.pairs] == [all_.pairs[0].name]
        np.testing.assert_array_equal(some.pairs[0].right, all_.pairs[0].right)
    with pytest.raises(InputError, match="limit of 0"):
        load_log(folder, limit=0)


@TREE
def test_one_sequence_is_a_scene(tmp_path: Path, name: str):
    folder = TREES[name](tmp_path)
    log = load_log(folder)
    assert log.name == "/".join(folder.parts[-2:])
    if len(log.missions) > 1:
        with pytest.raises(InputError, match=f"{len(log.missions)} sequences"):
            load_scene(folder)
        return
    scene = load_scene(folder)
    assert scene.name == log.missions[0].name
    assert scene.reference == "stored"
    assert list(log.calibrations) == ["stored"]
    np.testing.assert_array_equal(scene.rig.extrinsics, log.calibrations["stored"].extrinsics)


@TREE
def test_the_folder_may_be_the_working_directory(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch):
    folder = TREES[name](tmp_path)
    expected = load_log(folder)
    monkeypatch.chdir(folder)
    assert load_log(".").name == expected.name
    assert [mission.name for mission in load_log(".").missions] == [mission.name for mission in expected.missions]


@TREE
def test_a_bad_image_is_named(tmp_path: Path, name: str):
    folder = TREES[name](tmp_path)
    left, right = (Path(path) for path in load_log(folder).missions[-1].pairs[-1].origin[1][:2])
    whole = left.read_bytes()
    write_image(left, 0, (20, 16))
    refused(folder, str(left), "the left image is 20x16")
    left.write_bytes(whole[: len(whole) // 2])
    refused(folder, str(left), "truncated")
    left.write_bytes(right.read_bytes())
    refused(folder, left.name, "left and right are the same image")


@TREE
def test_a_missing_partner_is_named(tmp_path: Path, name: str):
    folder = TREES[name](tmp_path)
    left, right = (Path(path) for path in load_log(folder).missions[-1].pairs[-1].origin[1][:2])
    right.unlink()
    if name in ("euroc", "mav0"):  # there, one camera may have missed a frame
        assert left.name not in [pair.name for pair in load_log(folder).missions[0].pairs]
    elif name.startswith("middlebury"):
        refused(folder, f"{right}: there is no such file")
    else:
        refused(folder, f"{left}: this image has no partner on the right side")


@pytest.mark.parametrize("name", FIELD_TREES)
def test_a_distribution_that_is_not_installed_is_named(tmp_path: Path, name: str, nothing_installed):
    folder = FIELD_TREES[name](tmp_path)
    for read in (load_log, load_scene):
        with pytest.raises(InputError, match="run: pip install stereorecal-field"):
            read(folder)


def test_a_folder_that_is_none_of_these(tmp_path: Path):
    (tmp_path / "pictures").mkdir()
    refused(tmp_path, str(tmp_path), "scene folder", "plain log", "MODD2", "MODS", "KITTI raw", "KITTI odometry",
            "KITTI stereo 2012 or 2015", "EuRoC", "Middlebury")  # fmt: skip
    refused(tmp_path / "elsewhere", "no such folder")
