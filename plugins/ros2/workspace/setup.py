"""The node as a package of a ROS 2 workspace, for `colcon build`; `pip` goes by ../pyproject.toml.

In a folder of its own, since the setuptools of supported distributions cannot read that file; the package is a link.
"""

import tomllib
from pathlib import Path

from setuptools import setup

NAME = "stereorecal_ros"
PROJECT = tomllib.loads((Path("setup.py").resolve().parents[1] / "pyproject.toml").read_text())["project"]

setup(
    name=NAME,
    version=PROJECT["version"],
    description=PROJECT["description"],
    license=PROJECT["license"],
    packages=[NAME],
    package_data={NAME: ["py.typed", "launch/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", [f"{NAME}/launch/stereorecal.launch.xml"]),
    ],
    entry_points={"console_scripts": [f"{name} = {main}" for name, main in PROJECT["scripts"].items()]},
)
