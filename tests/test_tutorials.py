"""Tutorials whose commands are run: 3 and 9 in the folder that their first block makes, 5 and 10, which write plug-ins,
to the letter, each in an environment of its own. (Blocks of Python are run where the pages are.)"""

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest
from printed_output import agrees

PAGES = Path(__file__).parents[1] / "docs" / "tutorials"
STEP = re.compile(r"(?:\*\*`(?P<file>[^`]+)`\*\*\n\n)?```(?P<language>\w+)\n(?P<body>.*?)```", re.DOTALL)
SCRIPTS = "Scripts" if sys.platform == "win32" else "bin"


@pytest.fixture
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A new virtual environment that also sees what is installed in this one."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=True)
    site = next(home.glob("lib/python*/site-packages"), home / "Lib" / "site-packages")
    (site / "outer.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n")
    path = os.pathsep.join([str(home / SCRIPTS), os.environ["PATH"]])
    return os.environ | {"PATH": path, "VIRTUAL_ENV": str(home), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


def followed(page: str, environment: dict[str, str], folder: Path) -> str:
    """What the commands of a page print, in a folder; the page shows it truly."""
    output = printed = ""
    run = False  # whether the last block was one of commands
    for step in STEP.finditer((PAGES / page).read_text()):
        if step["file"]:
            (folder / step["file"]).write_text(step["body"])
        elif step["language"] == "output" and run:
            assert agrees(step["body"], printed), f"the page shows:\n{step['body']}\nprinted was:\n{printed}"
        elif step["language"] == "sh":
            printed = ""
            for line in step["body"].splitlines():
                done = subprocess.run(
                    line, shell=True, check=False, cwd=folder, env=environment, capture_output=True, text=True
                )
                assert (done.returncode, done.stderr) == (0, ""), f"{line}\n{done.stdout}{done.stderr}"
                printed += done.stdout
            output += printed
        run = step["language"] == "sh"
    return output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "written"),
    [
        (
            "03-your-own-calibration.md",
            [
                "camchain-shell.yaml",
                "ros_left-shell.yaml",
                "ros_right-shell.yaml",
                "stereo-shell.yaml",
                "stereo.yaml.bak",
            ],
        ),
        ("09-with-opencv.md", ["maps.npz"]),
    ],
)
def test_shell_lines(page: str, written: list[str]):
    names: dict[str, Path] = {}
    text = (PAGES / page).read_text()
    assert len(re.findall(r"```sh\n[^`]*```\n\n```output\n", text)) == text.count("```sh\n") > 0
    exec(re.findall(r"```python\n(.*?)```", text, re.DOTALL)[0], names)
    folder = names["folder"]
    before = set(folder.iterdir())
    here = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
    assert followed(page, os.environ | {"PATH": here}, folder)
    found = sorted(path.name for path in {*folder.iterdir()} - before)
    assert [name for name in found if not name.endswith(".prior.json")] == written  # what is known lies beside each


@pytest.mark.slow
def test_a_strategy_from_an_empty_folder_to_a_row_of_compare(environment: dict[str, str], tmp_path: Path):
    output = followed("05-write-a-strategy.md", environment, tmp_path)
    assert re.search(r"evolution +stereorecal-evolution +0\.1\.0 +host +Evolution \(1 \+ lambda\)", output)
    assert re.search(r"^\[0\.\d+ +0\.\d+ *\] 0\.9\d+ (CONVERGED|BUDGET) \d+\.0$", output, re.MULTILINE)
    assert "pass  repairs a stereo rig" in output
    assert "FAIL" not in output
    assert re.search(r"\d+ passed", output)
    assert re.search(r"evolution +\d+ % ", output)  # its row in the summary


@pytest.mark.slow
def test_a_matcher_from_an_empty_folder_to_its_name_on_the_command_line(environment: dict[str, str], tmp_path: Path):
    output = followed("10-write-a-matcher.md", environment, tmp_path)
    assert re.search(r"census +stereorecal-census +0\.1\.0 +on the host +Census transform", output)
    assert "pass  finds known shifts" in output
    assert "FAIL" not in output
    assert re.search(r"\d+ passed", output)
    rows = re.findall(r"^ (?:default|count) .*?(\d+) % ", output, re.MULTILINE)
    assert rows == ["100", "0"]  # by default it repairs; the count alone at that scale does not
