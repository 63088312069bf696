"""Names of calibrations, sequences and images stay in their folder."""

from dataclasses import replace
from pathlib import Path

import pytest

from stereorecal import InputError
from stereorecal.io import save_calibrations, save_mission
from stereorecal.recordings import Mission
from stereorecal.synthetic import default_rig, render

NAMES = ["../out", "/tmp/out", "..", ".", "", "a/b", "a\\b", "a\0b"]
RIG = default_rig().resized((160, 120))


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
