"""What is handed out: the wheel and the source distribution of the library and of each plug-in."""

import email
import importlib
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email.message import Message
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import stereorecal as sr

ROOT = Path(__file__).parents[1]
# What is compiled needs a compiler, and no test does; nor does `stereorecal[all]`.
PLUGINS = sorted(
    path.parent for path in ROOT.glob("plugins/*/pyproject.toml") if not path.with_name("CMakeLists.txt").exists()
)
PROJECTS = [ROOT, *PLUGINS]


class Built:
    """A project's wheel and source distribution: the names in them, and what they say of themselves."""

    def __init__(self, project: Path, folder: Path) -> None:
        settings = tomllib.loads((project / "pyproject.toml").read_text())
        build = importlib.import_module(settings["build-system"]["build-backend"])  # PEP 517
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(project)
            wheel, source = folder / build.build_wheel(str(folder)), folder / build.build_sdist(str(folder))
        with zipfile.ZipFile(wheel) as content:
            self.wheel = set(content.namelist())
            (self.about,) = {name.partition("/")[0] for name in self.wheel if ".dist-info/" in name}
            self.metadata: Message = email.message_from_bytes(content.read(f"{self.about}/METADATA"))
            self.licence = content.read(f"{self.about}/licenses/LICENSE").decode()
        with tarfile.open(source) as content:
            self.source = {name.partition("/")[2] for name in content.getnames()}

    def requirement(self, name: str) -> Requirement:
        """The one of that name that holds without an extra."""
        found = map(Requirement, self.metadata.get_all("Requires-Dist", []))
        (one,) = (needed for needed in found if needed.name == name and needed.marker is None)
        return one


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory):
    """built[project], built once."""
    return {project: Built(project, tmp_path_factory.mktemp("dist")) for project in PROJECTS}


def package_of(project: Path) -> Path:
    (package,) = (path.parent for path in project.glob("stereorecal*/__init__.py"))
    return package


@pytest.mark.parametrize("project", PROJECTS, ids=lambda path: path.name)
def test_every_file_of_the_package_is_in_it(built, project: Path):
    """Templates, styles and stubs are read at run time, and nothing but a wheel without them tells that."""
    package = package_of(project)
    files = {
        path.relative_to(project).as_posix()
        for path in package.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert f"{package.name}/py.typed" in files
    assert {name for name in built[project].wheel if ".dist-info/" not in name} == files
    assert files <= built[project].source


@pytest.mark.parametrize("project", PROJECTS, ids=lambda path: path.name)
def test_the_licence_travels_along(built, project: Path):
    found = built[project]
    assert found.metadata["License-Expression"] == "Apache-2.0"
    assert found.metadata.get_all("License-File") == ["LICENSE"]
    assert "The stereorecal authors" in found.licence
    assert found.licence == (ROOT / "LICENSE").read_text()
    assert {"LICENSE", "pyproject.toml", "PKG-INFO"} <= found.source


@pytest.mark.parametrize("project", PROJECTS, ids=lambda path: path.name)
def test_what_it_says_of_itself(built, project: Path):
    metadata = built[project].metadata
    assert metadata["Summary"].endswith(".")
    assert metadata["Keywords"]
    assert "Typing :: Typed" in metadata.get_all("Classifier")


def test_one_version(built):
    assert built[ROOT].metadata["Version"] == sr.__version__
    said = subprocess.run(
        [sys.executable, "-m", "stereorecal", "--version"], capture_output=True, text=True, check=True
    )
    assert said.stdout == f"stereorecal {sr.__version__}\n"


@pytest.mark.parametrize("project", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_says_which_library_it_is_for(built, project: Path):
    """This one, and none whose contract nobody has seen."""
    bound = built[project].requirement("stereorecal").specifier
    assert bound.contains(sr.__version__)
    assert not bound.contains("0.0.9")
    major, minor, *_ = Version(sr.__version__).release
    assert not bound.contains(f"{major}.{minor + 1}.0")


def test_plugins_ask_for_what_the_library_asks_for(built):
    """One range for each library that several of them need."""
    for project in PLUGINS:
        for name in ("jax", "numpy", "jaxtyping", "opencv-python-headless"):
            try:
                theirs = built[project].requirement(name)
            except ValueError:
                continue
            assert theirs.specifier == built[ROOT].requirement(name).specifier, project.name


def test_all_is_every_distribution_and_every_extra(built):
    metadata = built[ROOT].metadata

    def brought(extra: str) -> set[str]:
        needed = map(Requirement, metadata.get_all("Requires-Dist"))
        return {one.name for one in needed if one.marker and one.marker.evaluate({"extra": extra})}

    extras = set(metadata.get_all("Provides-Extra")) - {"all", "docs", "test"}
    plugins = {built[project].metadata["Name"] for project in PLUGINS}
    assert brought("all") == plugins.union(*map(brought, extras))
