"""Plain logs: what is written comes back, nothing is overwritten unasked, names stay in their folder."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stereorecal_paper import has_mission, save_calibrations, save_mission

from stereorecal import InputError
from stereorecal.io import load_log, load_rig, save_rig
from stereorecal.recordings import Mission
from stereorecal.synthetic import default_rig, render

NAMES = ["../out", "/tmp/out", "..", ".", "", "a/b", "a\\b", "a\0b"]
RIG = default_rig().resized((160, 120))
CALIBRATIONS = {"2020-05-01": RIG, "2021-01-01": RIG.with_extrinsics(RIG.extrinsics + 0.01 * np.eye(6)[0])}


@pytest.fixture
def mission(scene) -> Mission:
    taken = scene(frames=3)
    pairs = tuple(replace(pair, name=f"{index:03d}.png") for index, pair in enumerate(taken.pairs))
    return Mission("2020-05-02-pier", "2020-05-01", pairs, frozenset({"001.png"}), taken.rig)


@pytest.fixture
def folder(tmp_path: Path, mission: Mission) -> Path:
    save_calibrations(CALIBRATIONS, tmp_path / "log")
    save_mission(mission, tmp_path / "log")
    return tmp_path / "log"


def test_what_is_written_comes_back(folder: Path, mission: Mission):
    log = load_log(folder)
    assert list(log.calibrations) == list(CALIBRATIONS)
    for name, rig in CALIBRATIONS.items():
        np.testing.assert_allclose(log.calibrations[name].extrinsics, rig.extrinsics, atol=1e-12)
    (found,) = log.missions
    assert (found.name, found.calibration, found.starred) == (mission.name, mission.calibration, mission.starred)
    assert found.truth is not None
    np.testing.assert_allclose(found.truth.extrinsics, mission.truth.extrinsics, atol=1e-12)
    for pair, original in zip(found.pairs, mission.pairs, strict=True):
        assert pair.name == original.name
        np.testing.assert_allclose(pair.left, original.left, atol=0.5)
        np.testing.assert_allclose(pair.right, original.right, atol=0.5)


def test_a_log_takes_no_keys_of_a_scene(tmp_path: Path):
    save_rig(default_rig(), tmp_path / "calib.json", {"boat": "Ladja"})
    save_calibrations({"may": load_rig(tmp_path / "calib.json")}, tmp_path)
    (written,) = tmp_path.glob("*/may.json")
    assert "boat" not in written.read_text()


def test_names_of_pairs_are_kept_apart(folder: Path, mission: Mission):
    """coast-0.1 is no file type, and what was a JPEG is written as PNG; stars go along."""
    names = ["coast-0.1", "coast-0.2", "x.jpg"]
    pairs = tuple(replace(pair, name=name) for name, pair in zip(names, mission.pairs, strict=True))
    save_mission(replace(mission, name="2020-06-01", pairs=pairs, starred=frozenset({"x.jpg"})), folder)
    found = load_log(folder).missions[1]
    assert [pair.name for pair in found.pairs] == ["coast-0.1.png", "coast-0.2.png", "x.png"]
    assert found.starred == {"x.png"}
    clash = tuple(replace(pair, name=name) for name, pair in zip(["a.jpg", "a.png", "b"], mission.pairs, strict=True))
    with pytest.raises(InputError, match="under the same name"):
        save_mission(replace(mission, name="2020-06-02", pairs=clash, starred=frozenset()), folder)


def test_nothing_is_overwritten_unasked(folder: Path, mission: Mission):
    with pytest.raises(InputError, match="is there already"):
        save_mission(mission, folder)
    with pytest.raises(InputError, match="exists already"):
        save_calibrations(CALIBRATIONS, folder)
    save_calibrations(CALIBRATIONS, folder, overwrite=True)


def test_a_mission_is_there_once_it_is_whole(folder: Path, mission: Mission):
    assert has_mission(folder, mission.name)
    (folder / "sequences" / mission.name / "mission.json").unlink()  # written last
    assert not has_mission(folder, mission.name)


@pytest.mark.parametrize("name", NAMES)
def test_names_that_climb(tmp_path: Path, name: str):
    place = tmp_path / "log"
    pair = render("harbour", 0, rig=RIG).pairs[0]
    with pytest.raises(InputError, match="cannot be the name of a file"):
        save_calibrations({"good": RIG, name: RIG}, place)
    with pytest.raises(InputError, match="cannot be the name of a file"):
        save_mission(Mission(name, "good", (pair,)), place)
    with pytest.raises(InputError, match="cannot be the name of a file"):
        save_mission(Mission("good", "good", (replace(pair, name=name),)), place)
    assert list(tmp_path.rglob("*")) == []
