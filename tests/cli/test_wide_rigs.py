"""Rigs with wide lenses from their own files to repaired ones and back, and the view that is looked through."""

import json
from pathlib import Path

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import save_scene

SIZE = (320, 240)
TERMS = np.array([-0.02, -0.007, 0.002, -0.001])
DRIFT = np.array([np.radians(0.5), np.radians(-0.7), np.radians(0.9), 0.0, 0.004, -0.003])


def fisheye(columns: float, rows: float) -> Camera:
    matrix = np.array([[96.5, 0, columns], [0, 96.7, rows], [0, 0, 1]])  # 190 degrees
    return Camera(SIZE, matrix, TERMS, model="equidistant")


RIG = StereoRig(fisheye(161.2, 118.0), fisheye(158.5, 120.5), np.array([0.004, -0.006, 0.003, -0.36, 0.002, -0.001]))


@pytest.fixture(scope="module")
def drifted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with a camchain beside it, as people comment it."""
    folder = tmp_path_factory.mktemp("wide") / "street"
    scene = sr.synthetic.render("street", 1, rig=RIG)
    save_scene(scene, folder)
    sr.io.save_rig(RIG.with_extrinsics(RIG.extrinsics + DRIFT), folder / "plain.yaml", format="kalibr")
    lines = (folder / "plain.yaml").read_text().splitlines()
    (folder / "camchain.yaml").write_text("\n".join(["# by Kalibr, on a Tuesday", *lines, "# the end"]) + "\n")
    return folder


def images(folder: Path) -> tuple[object, ...]:
    return "--left", folder / "left.png", "--right", folder / "right.png"


@pytest.mark.slow
def test_one_option_says_through_which_view_every_command_looks(command, drifted: Path, tmp_path: Path):
    words = (*images(drifted), "--calibration", drifted / "calib.json", "--view", "projection=pinhole,field=100")
    told = tmp_path / "health.json"
    assert command("score", *words, "--json", told).code in (0, 4)
    content = json.loads(told.read_text())
    assert content["settings"]["view"] == "projection=pinhole,field=100"
    assert content["scenes"][0]["view"]["degrees"] == pytest.approx(100.0)
    state = tmp_path / "state"
    assert command("monitor", *words, "--state", state, "--quiet").code in (0, 4)
    kept = sr.online.load(state)
    assert (kept.view.projection, kept.config.projection, kept.config.field) == ("pinhole", "pinhole", 100.0)
    other = command("monitor", *words[:-1], "field=120", "--state", state)
    other.refuses("was made with another view; leave --view out")
    assert command("monitor", *words[:-2], "--state", state, "--quiet").code in (0, 4)
