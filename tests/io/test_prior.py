"""What is known of a calibration, with it or beside it: both are written or none, and it is of these numbers alone."""

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from machine import full_disk
from refusals import refused

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig, rig_as_data, rig_from_data, same_rig
from stereorecal.io import calibration_json, load_rig, load_scene, save_rig, save_scene

SIZE = (160, 120)
FORMS = {
    "stereorecal": ("calib.json",),
    "opencv": ("calib.yaml",),
    "kalibr": ("chain.yaml",),
    "ros": ("left.yaml", "right.yaml"),
    "boofcv": ("stereo.yaml",),
}


def rig_of(extrinsics, k1: float = 0.1) -> StereoRig:
    matrix = np.array([[150.1, 0, 79.3], [0, 149.9, 60.7], [0, 0, 1]])
    lens = np.array([k1, -0.02, 1e-4, 1e-7])
    return StereoRig(Camera(SIZE, matrix, lens), Camera(SIZE, matrix + 0.0, lens), np.array(extrinsics))


RIG = rig_of([0.01, -0.02, 0.03, -0.356, 0.004, -0.003])


@dataclass(frozen=True)
class Known:
    """As little as a prior can be."""

    rig: StereoRig
    numbers: tuple[float, ...] = (1 / 3, 1e-300)

    def as_dict(self):
        return {"schema": "test", "rig": rig_as_data(self.rig), "numbers": list(self.numbers)}

    def check(self, rig: StereoRig) -> None:
        if not same_rig(self.rig, rig):
            raise InputError("another rig")


def places(folder: Path, name: str) -> list[Path]:
    return [folder / file for file in FORMS[name]]


def beside(folder: Path, name: str) -> Path:
    return folder / f"{FORMS[name][0]}.prior.json"


def content(rig: StereoRig):
    stored = rig.source.prior
    return None if stored is None else stored.content


@given(
    angles=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    shift=st.tuples(st.floats(-2.0, -0.01), st.floats(-0.009, 0.009), st.floats(-0.009, 0.009)),
    k1=st.floats(-0.3, 0.3),
)
def test_a_rig_as_data_is_the_rig(angles, shift, k1):
    rig = rig_of([*angles, *shift], k1)
    again = rig_from_data(json.loads(json.dumps(rig_as_data(rig))))
    np.testing.assert_array_equal(again.extrinsics, rig.extrinsics)
    np.testing.assert_array_equal(again.left.distortion, rig.left.distortion)
    assert same_rig(again, rig)
    assert not same_rig(again, rig.with_extrinsics(rig.extrinsics + 1e-6))


@pytest.mark.parametrize("name", FORMS)
def test_it_comes_back_from_every_format(tmp_path: Path, name: str):
    """What was written with a calibration is known of that one, and of no other."""
    known, (path, *_) = Known(RIG, (0.1, -2e-17, 5e-324, 1e300)), places(tmp_path, name)
    save_rig(RIG, places(tmp_path, name), format=name)
    assert len(list(tmp_path.iterdir())) == len(FORMS[name])
    assert content(load_rig(tmp_path, unit="m")) is None
    save_rig(RIG, places(tmp_path, name), format=name, overwrite=True, prior=known)
    stored = load_rig(tmp_path, unit="m").source.prior  # the folder: what lies beside is no calibration
    assert stored is not None
    assert stored.content == known.as_dict()
    assert stored.of(load_rig(places(tmp_path, name), unit="m"))
    assert beside(tmp_path, name).exists() == (name != "stereorecal")
    assert "150.1" in path.read_text()
    path.write_text(path.read_text().replace("150.1", "150.2", 1))
    changed = load_rig(tmp_path, unit="m")
    stored = changed.source.prior
    assert stored is not None
    assert not stored.of(changed)


@pytest.mark.parametrize("target", FORMS)
@pytest.mark.parametrize("source", ["stereorecal", "kalibr"])
def test_it_goes_with_the_rig_into_other_formats(tmp_path: Path, source: str, target: str):
    for folder in ("a", "b", "c"):
        (tmp_path / folder).mkdir()
    save_rig(RIG, places(tmp_path / "a", source), format=source, prior=Known(RIG))
    rig = load_rig(tmp_path / "a")
    save_rig(rig, places(tmp_path / "b", target), format=target)
    assert content(load_rig(tmp_path / "b", unit="m")) == Known(RIG).as_dict()
    moved = rig.with_extrinsics(rig.extrinsics + 0.001)
    save_rig(moved, places(tmp_path / "c", target), format=target)  # which it says nothing of
    assert content(load_rig(tmp_path / "c", unit="m")) is None


def test_a_prior_of_another_rig_is_not_written(tmp_path: Path):
    moved = RIG.with_extrinsics(RIG.extrinsics + 0.001)
    with pytest.raises(InputError, match="another rig"):
        save_rig(moved, tmp_path / "c.yaml", prior=Known(RIG))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("damage", [b"", b"[]", b"\xff\xfe", b'{"rig": {}}'])
def test_a_damaged_file_is_named_once_it_is_asked_for(tmp_path: Path, damage: bytes):
    save_rig(RIG, tmp_path / "c.yaml", prior=Known(RIG))
    (tmp_path / "c.yaml.prior.json").write_bytes(damage)
    rig = load_rig(tmp_path / "c.yaml", unit="m")
    stored = rig.source.prior
    assert stored is not None
    said = "" if stored.problem else "there is no rig in it; copy it again, or delete it."
    refused(lambda: stored.of(rig), "c.yaml.prior.json: ", said)
    refused(lambda: save_rig(rig, tmp_path / "new.yaml"), "c.yaml.prior.json: ")  # it would be lost
    save_rig(rig, tmp_path / "new.yaml", prior=Known(rig))
    assert (tmp_path / "c.yaml.prior.json").read_bytes() == damage


@pytest.mark.parametrize("failing", [1, 2])
def test_a_full_disk_leaves_both_as_they_were(tmp_path: Path, failing: int):
    path = tmp_path / "c.yaml"
    save_rig(RIG, path, prior=Known(RIG))
    before = {each: each.read_bytes() for each in tmp_path.iterdir()}
    moved = RIG.with_extrinsics(RIG.extrinsics + 0.001)
    with full_disk(nth=failing):
        refused(lambda: save_rig(moved, path, overwrite=True, prior=Known(moved)), "No space left")
    assert {each: each.read_bytes() for each in tmp_path.iterdir()} == before


@pytest.mark.parametrize("taken", ["c.yaml", "c.yaml.prior.json"])
def test_neither_is_replaced_unless_allowed(tmp_path: Path, taken: str):
    (tmp_path / taken).write_text("precious")
    refused(lambda: save_rig(RIG, tmp_path / "c.yaml", prior=Known(RIG)), "exists already")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [(taken, "precious")]


def test_a_device_has_nothing_beside_it():
    save_rig(RIG, os.devnull, format="kalibr", overwrite=True, prior=Known(RIG))
    assert not Path(f"{os.devnull}.prior.json").exists()


def test_in_a_calib_json_it_takes_one_line_and_the_rest_stays(tmp_path: Path):
    path = tmp_path / "calib.json"
    save_rig(RIG, path, {"boat": "Ladja"})
    plain = path.read_text()
    save_rig(load_rig(path), path, overwrite=True, prior=Known(RIG))
    lines = [line.rstrip(",") for line in path.read_text().splitlines() if '"prior"' not in line]
    assert lines == [line.rstrip(",") for line in plain.splitlines()]
    assert len(path.read_text().splitlines()) == len(lines) + 1
    assert json.loads(path.read_text())["boat"] == "Ladja"
    printed = json.loads(calibration_json(RIG, Known(RIG)))
    assert printed["prior"] == Known(RIG).as_dict()


def test_a_scene_keeps_it_and_does_not_take_it_for_a_key_of_the_users(scene, tmp_path: Path):
    first = scene()
    save_scene(first, tmp_path / "a")
    path = tmp_path / "a" / "calib.json"
    known = Known(load_rig(path))
    save_rig(known.rig, path, overwrite=True, prior=known)
    found = load_scene(tmp_path / "a")
    assert "prior" not in found.info
    save_scene(found, tmp_path / "b")
    assert content(load_rig(tmp_path / "b")) == known.as_dict()
    moved = found.rig.with_extrinsics(found.rig.extrinsics + 0.001)
    save_scene(replace(found, rig=moved), tmp_path / "c")
    assert content(load_rig(tmp_path / "c")) is None
