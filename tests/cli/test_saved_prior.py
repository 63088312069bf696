"""`recalibrate` twice: what the first repair knew is with its calibration, and the second begins with it."""

import json
from pathlib import Path

import pytest

from stereorecal.io import load_scene, save_rig

COUNT = ("--schedule", "count")


@pytest.fixture(scope="module")
def sides(drifted_scene: Path) -> tuple:
    return "--left", drifted_scene / "left.png", "--right", drifted_scene / "right.png", "--unit", "m"


@pytest.fixture(scope="module")
def drifted(drifted_scene: Path, sides, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """The same recording, with a calibration in a format without a place for a prior."""
    path = tmp_path_factory.mktemp("given") / "given.yaml"
    save_rig(load_scene(drifted_scene).rig, path, format="opencv")
    return *sides, "--calibration", path


def again(command, sides, calibration: Path, *words, unit: bool = True):
    """The answer, and what the JSON says of priors."""
    target = calibration.with_name("said.json")
    some = sides if unit else sides[:-2]
    answer = command("recalibrate", *some, "--calibration", calibration, "--json", target, "--force", *words)
    content = json.loads(target.read_text()) if target.exists() else None
    return answer, content and (content["settings"]["prior"], content["repairs"][0]["prior"])


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", ["calib.json", "calib.yaml"])
def test_the_second_call_begins_with_it(command, drifted_scene: Path, drifted, sides, tmp_path: Path, name: str):
    path = tmp_path / name
    answer = command("recalibrate", *(drifted if name == "calib.yaml" else [drifted_scene]), "--output", path)
    assert (answer.code, answer.err) == (0, "")
    beside = tmp_path / f"{name}.prior.json"
    assert beside.exists() == (name == "calib.yaml")
    assert ("keep it with the calibration" in answer.out) == beside.exists()
    before = path.read_bytes()
    answer, (asked, used) = again(command, sides, path, unit=name == "calib.yaml")
    assert asked == "saved"
    assert used["name"] == "saved, without these pairs"
    assert "prior    saved, without these pairs" in answer.out
    answer, (asked, used) = again(command, sides, path, "--prior", "default", unit=name == "calib.yaml")
    assert (asked, used["name"]) == ("default", "default")
    assert "prior    " not in answer.out
    assert path.read_bytes() == before


def test_a_damaged_file(command, sides, drifted, tmp_path: Path):
    repaired, beside = tmp_path / "calib.yaml", tmp_path / "calib.yaml.prior.json"
    assert command("recalibrate", *drifted, *COUNT, "--output", repaired).code == 0
    beside.write_text("{")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    answer, _ = again(command, sides, repaired, *COUNT, "--output", repaired, "--force")
    answer.refuses(f"{beside}: ")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    answer, _ = again(command, sides, repaired, *COUNT, "--prior", "default")
    assert answer.code in (0, 1)


def test_both_old_ones_are_kept(command, sides, drifted_scene: Path, drifted, tmp_path: Path):
    """Repaired quickly, by the count: depth is then not known."""
    repaired, beside = tmp_path / "calib.yaml", tmp_path / "calib.yaml.prior.json"
    assert command("recalibrate", *drifted, *COUNT, "--output", repaired).code == 0
    assert json.loads(beside.read_text())["components"] is None
    command("convert", drifted_scene / "calib.json", repaired, "--force")  # the old beside it is now of another
    old = beside.read_bytes() + b"\n"
    beside.write_bytes(old)
    answer, _ = again(command, sides, repaired, *COUNT, "--output", repaired, "--force")
    assert answer.code == 0
    assert beside.with_name(f"{beside.name}.bak").read_bytes() == old
    assert beside.read_bytes() != old
