"""A baseline in other units than metres is said, not refused."""

import json
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereorecal import CalibrationWarning
from stereorecal.geometry import StereoRig
from stereorecal.io import gather_scene, load_log, load_rig, load_scene, save_rig, save_scene
from stereorecal.synthetic import default_rig, render

RIG = default_rig().resized((160, 120))
LENGTH = float(RIG.baseline)


def scaled(factor: float) -> StereoRig:
    return RIG.with_extrinsics(RIG.extrinsics * [1, 1, 1, factor, factor, factor])


@pytest.fixture(scope="module")
def millimetres(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene folder whose translation was never converted."""
    folder = tmp_path_factory.mktemp("units") / "millimetres"
    save_scene(replace(render("harbour", 0, rig=RIG), rig=scaled(1000.0)), folder)
    return folder


@pytest.mark.parametrize("length", [0.0049, 5.01, 356.04])
def test_unusual(tmp_path: Path, length: float):
    save_rig(scaled(length / LENGTH), tmp_path / "rig.json")
    with pytest.warns(CalibrationWarning) as found:
        rig = load_rig(tmp_path / "rig.json")
    assert rig.baseline == pytest.approx(length)
    (warning,) = found
    assert str(warning.message) == (
        f"{tmp_path}/rig.json: the baseline is {length:.3g} m long; check that the translation is in metres."
    )


@pytest.mark.parametrize("length", [0.0051, 0.356, 4.99])
def test_usual(tmp_path: Path, length: float):
    save_rig(scaled(length / LENGTH), tmp_path / "rig.json")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_rig(tmp_path / "rig.json")


def test_it_points_at_the_line_of_the_user(millimetres: Path, tmp_path: Path):
    """In a process of its own: the type checker of the tests stands between a function and its caller."""
    program = tmp_path / "program.py"
    program.write_text(f"import stereorecal as sr\nsr.io.load_scene({str(millimetres)!r})\n")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True)
    assert done.stderr.startswith(f"{program}:2: CalibrationWarning: {millimetres}: the baseline is 356 m long")


def test_every_reader(millimetres: Path):
    """Each says it once; what is read is as the file has it."""
    images = [millimetres / f"{side}.png" for side in ("left", "right")]
    readers = (
        lambda: load_rig(millimetres / "calib.json"),
        lambda: load_scene(millimetres).rig,
        lambda: gather_scene(*images, millimetres / "calib.json").rig,
        lambda: next(iter(load_log(millimetres).calibrations.values())),
    )
    for read in readers:
        with pytest.warns(CalibrationWarning, match="the baseline is 356") as found:
            rig = read()
        assert len(found) == 1
        np.testing.assert_allclose(rig.extrinsics, scaled(1000.0).extrinsics, atol=1e-9)


def test_no_rig_no_warning(millimetres: Path, tmp_path: Path):
    save_scene(replace(render("harbour", 0, rig=RIG), rig=None), tmp_path / "none")
    assert json.loads((tmp_path / "none" / "calib.json").read_text())["T"] is None
    assert load_scene(tmp_path / "none").rig is None
