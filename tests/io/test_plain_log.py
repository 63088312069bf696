"""The plain log: dates find their calibration, what does not fit is refused."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import stereorecal as sr
from stereorecal.io import load_log, load_scene, make_folder, save_rig, save_scene
from stereorecal.recordings import Log, Mission


@pytest.fixture
def mission(scene) -> Mission:
    taken = scene(frames=3)
    pairs = tuple(replace(pair, name=f"{index:03d}.png") for index, pair in enumerate(taken.pairs))
    return Mission("2020-05-02-pier", "2020-05-01", pairs, frozenset({"001.png"}), taken.rig)


@pytest.fixture
def calibrations(scene) -> dict[str, sr.StereoRig]:
    rig = scene().rig
    shift = np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0])
    return {"2020-05-01": rig, "2021-01-01": rig.with_extrinsics(rig.extrinsics + shift)}


def add(mission: Mission, log: Path) -> None:
    """One sequence more."""
    place = log / "sequences" / mission.name
    save_scene(sr.Scene(mission.name, mission.truth, mission.pairs), place)
    (place / "calib.json").rename(place / "truth.json")
    facts = {"calibration": mission.calibration, "starred": sorted(mission.starred)}
    (place / "mission.json").write_text(json.dumps(facts))


@pytest.fixture
def folder(tmp_path: Path, mission: Mission, calibrations) -> Path:
    log = tmp_path / "log"
    make_folder(log / "calibrations")
    for name, rig in calibrations.items():
        save_rig(rig, log / "calibrations" / f"{name}.json", format="stereorecal")
    add(mission, log)
    return log


def test_what_is_in_it(folder: Path, mission: Mission, calibrations):
    log = load_log(folder)
    assert list(log.calibrations) == list(calibrations)
    (found,) = log.missions
    assert (found.name, found.calibration, found.starred) == (mission.name, mission.calibration, mission.starred)
    assert found.truth is not None
    np.testing.assert_allclose(found.truth.extrinsics, mission.truth.extrinsics, atol=1e-12)
    assert [pair.name for pair in found.pairs] == [pair.name for pair in mission.pairs]


def test_one_sequence_of_several(folder: Path, mission: Mission, calibrations, monkeypatch):
    """By its path, also one that is relative; all of them at once are no scene."""
    add(replace(mission, name="2021-02-03-bay", calibration=None), folder)
    refused(lambda: load_scene(folder), "2 sequences are in there")
    monkeypatch.chdir(folder / "sequences" / "2021-02-03-bay")
    for place, date in ((folder / "sequences" / mission.name, "2020-05-01"), (Path("."), "2021-01-01")):
        found = load_scene(place)
        assert found.name == ("2021-02-03-bay" if place == Path(".") else mission.name)
        assert found.rig is not None
        np.testing.assert_allclose(found.rig.extrinsics, calibrations[date].extrinsics, atol=1e-12)
        assert len(found.pairs) == len(mission.pairs)


def test_a_calibration_that_looks_wrong_is_named_once(folder: Path):
    for path in (folder / "calibrations").iterdir():
        content = json.loads(path.read_text())
        path.write_text(json.dumps(content | {"T": [1000 * x for x in content["T"]]}))
    with pytest.warns(sr.CalibrationWarning, match="the baseline is") as found:
        load_log(folder)
    assert len(found) == 1


@pytest.mark.parametrize(
    ("name", "calibration"),
    [("2020-05-01", "2020-05-01"), ("2020-12-31-x", "2020-05-01"), ("2022-x", "2021-01-01"), ("2019-01-01-x", None)],
)
def test_the_last_calibration_before_a_sequence_holds(folder: Path, name: str, calibration: str | None):
    sequence = folder / "sequences" / "2020-05-02-pier"
    (sequence / "mission.json").unlink()
    sequence.rename(folder / "sequences" / name)
    if calibration is None:
        refused(lambda: load_log(folder), "no calibration is of that date or before it")
    else:
        assert load_log(folder).missions[0].calibration == calibration


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"starred": "001.png"}, "list of image names"),
        ({"starred": [["001.png"]]}, "list of image names"),
        ({"starred": ["nothing.png"]}, "no left image"),
        ({"calibration": ["2020-05-01"]}, "name of a calibration"),
        ({"calibration": "2020-05-07"}, "no calibration '2020-05-07' in the log"),
    ],
)
def test_facts_that_make_no_sense(folder: Path, facts, said):
    (folder / "sequences" / "2020-05-02-pier" / "mission.json").write_text(json.dumps(facts))
    refused(lambda: load_log(folder), "2020-05-02-pier", said)


def test_one_sequence_is_a_scene_and_a_scene_is_a_log(folder: Path, tmp_path: Path, mission: Mission, scene):
    found = load_scene(folder)
    assert (found.name, len(found.pairs)) == (mission.name, 3)
    save_scene(scene(), tmp_path / "scene")
    log = load_log(tmp_path / "scene")
    assert [m.truth is not None for m in log.missions] == [True]
    np.testing.assert_allclose(log.calibration_of(log.missions[0]).extrinsics, scene().rig.extrinsics, atol=1e-12)


def test_logs_that_contradict_themselves(mission: Mission, calibrations):
    same = replace(mission, pairs=(mission.pairs[0], mission.pairs[0]))
    small = {name: rig.resized((80, 60)) for name, rig in calibrations.items()}
    refused(lambda: Log("x", calibrations, ()), "no sequence")
    refused(lambda: Log("x", calibrations, (mission, mission)), "same name")
    refused(lambda: Log("x", calibrations, (same,)), "two pairs have the same name")
    refused(lambda: Log("x", small, (mission,)), "same size")
