"""What the launch file and the page say is what there is; without ROS the program says how to get it."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

from stereorecal_ros import Settings
from stereorecal_ros._settings import about, changes

PAGE = Path(__file__).parents[3] / "docs" / "tutorials" / "11-ros-2.md"


def test_the_launch_file():
    launch = ElementTree.fromstring((files("stereorecal_ros") / "launch" / "stereorecal.launch.xml").read_text())
    declared = {one.attrib["name"]: one.attrib["default"] for one in launch.iter("arg")}
    (executable,) = launch.iter("executable")
    command = executable.attrib["cmd"]
    assert set(re.findall(r"\$\(var (\w+)\)", command)) == set(declared)
    defaults = {one.name: one.default for one in fields(Settings)}
    for name in re.findall(r"-p (\w+):=", command):
        assert str(defaults[name]).lower() == declared[name]


def test_the_page_lists_every_parameter():
    table = PAGE.read_text().partition("| parameter |")[2]
    rows = {name: (default, text) for name, default, text in re.findall(r"^\| `(\w+)` \| (\S*) ?\| (.*)", table, re.M)}
    assert set(rows) == {one.name for one in fields(Settings)}
    for one in fields(Settings):
        default, text = rows[one.name]
        assert default == {"True": "true", "False": "false", "('',)": ""}.get(str(one.default), str(one.default))
        assert ("may change while" in text) is changes(one.name)
        assert about(one.name)


def test_without_ros(tmp_path: Path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('No module named rclpy')\n")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    code += "from stereorecal_ros.__main__ import main\nsys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "there is no ROS 2 here" in done.stderr
    assert "pip install 'stereorecal-ros[ros]'" in done.stderr
