"""A baseline in other units than metres is said, not refused."""

import shutil
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gathered import gathered

from stereorecal import CalibrationWarning
from stereorecal.geometry import StereoRig
from stereorecal.io import load_log, load_rig, load_scene, save_rig, save_scene
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


@pytest.mark.parametrize(("length", "usual"), [(0.0049, False), (0.0051, True), (4.99, True), (5.01, False)])
def test_lengths(tmp_path: Path, length: float, usual: bool):
    path = tmp_path / "rig.json"
    save_rig(scaled(length / LENGTH), path)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        assert load_rig(path).baseline == pytest.approx(length)
    said = (
        f"{path}: the baseline is {length:.3g} m long; check that the translation is in metres, or give its unit "
        "(--unit)."
    )
    assert [str(one.message) for one in found] == [said] * (not usual)


def test_it_points_at_the_line_of_the_user(millimetres: Path, tmp_path: Path):
    """In a process of its own: the type checker of the tests stands between a function and its caller."""
    program = tmp_path / "program.py"
    for side, names in (("left", "ab"), ("right", "xy")):
        (tmp_path / side).mkdir()
        for name in names:
            shutil.copy(millimetres / f"{side}.png", tmp_path / side / f"{name}.png")
    lines = f"sr.io.load_scene({str(millimetres)!r})", "sr.io.load_pairs('left', 'right')"
    program.write_text("\n".join(["import stereorecal as sr", *lines, ""]))
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stderr.startswith(f"{program}:2: CalibrationWarning: {millimetres}: the baseline is 356 m long")
    assert f"{program}:3: PairingWarning: " in done.stderr


@pytest.mark.parametrize(
    "read",
    [
        lambda folder: load_rig(folder / "calib.json"),
        lambda folder: load_scene(folder).rig,
        lambda folder: gathered(folder / "left.png", folder / "right.png", folder / "calib.json").rig,
        lambda folder: load_log(folder).calibrations["stored"],
    ],
)
def test_every_reader_says_it_once(millimetres: Path, read):
    """What is read is as the file has it."""
    with pytest.warns(CalibrationWarning, match="the baseline is 356") as found:
        rig = read(millimetres)
    assert len(found) == 1
    np.testing.assert_allclose(rig.extrinsics, scaled(1000.0).extrinsics, atol=1e-9)
