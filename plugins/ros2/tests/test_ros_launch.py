"""What the launch file, the package of a workspace and the page say is what there is; without ROS the program says how
to get it."""

import ast
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

from stereorecal_ros import Settings
from stereorecal_ros._settings import about, changes

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "ros-2.md"
PLUGIN = Path(__file__).parents[1]


def test_the_launch_file():
    launch = ElementTree.fromstring((files("stereorecal_ros") / "launch" / "stereorecal.launch.xml").read_text())
    declared = {one.attrib["name"]: one.attrib["default"] for one in launch.iter("arg")}
    (executable,) = launch.iter("executable")
    command = executable.attrib["cmd"]
    assert set(re.findall(r"\$\(var (\w+)\)", command)) == set(declared)
    defaults = {one.name: one.default for one in fields(Settings)}
    for name in re.findall(r"-p (\w+):=", command):
        assert str(defaults[name]).lower() == declared[name]


def test_the_package_of_a_workspace():
    """`colcon build` goes by it; it names the version, and what of ROS is imported."""
    there = PLUGIN / "workspace"
    package = ElementTree.parse(there / "package.xml").getroot()
    project = tomllib.loads((PLUGIN / "pyproject.toml").read_text())["project"]
    assert package.findtext("name") == "stereorecal_ros"
    assert package.findtext("version") == project["version"]
    assert package.findtext("export/build_type") == "ament_python"
    trees = [ast.parse(path.read_text()) for path in (PLUGIN / "stereorecal_ros").glob("*.py")]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    imported = {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    imported |= {one.name for node in nodes if isinstance(node, ast.Import) for one in node.names}
    roots = {name.partition(".")[0] for name in imported if name}
    of_python = {"cv2", "jaxtyping", "numpy", "stereorecal", "stereorecal_ros", "yaml"} | sys.stdlib_module_names
    assert {one.text for one in package.iter("exec_depend")} == roots - of_python
    assert (there / "stereorecal_ros" / "_node.py").samefile(PLUGIN / "stereorecal_ros" / "_node.py")


def test_the_page_lists_every_parameter():
    table = PAGE.read_text().partition("| parameter |")[2]
    rows = {name: (default, text) for name, default, text in re.findall(r"^\| `(\w+)` \| (\S*) ?\| (.*)", table, re.M)}
    assert set(rows) == {one.name for one in fields(Settings)}
    for one in fields(Settings):
        default, text = rows[one.name]
        assert default == {"True": "true", "False": "false", "('',)": ""}.get(str(one.default), str(one.default))
        assert text.rstrip("| ").endswith("; *") is changes(one.name)  # may change while the node runs
        assert about(one.name)


def test_without_ros(tmp_path: Path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('No module named rclpy')\n")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    code += "from stereorecal_ros.__main__ import main\nsys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "there is no ROS 2 here" in done.stderr
    assert "pip install 'stereorecal-ros[ros]'" in done.stderr
