"""Tutorial 5, followed to the letter in an environment of its own."""

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[1] / "docs" / "tutorials" / "05-write-a-strategy.md"
STEP = re.compile(r"(?:\*\*`(?P<file>[^`]+)`\*\*\n\n)?```(?P<language>\w+)\n(?P<body>.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A new virtual environment that also sees what is installed in this one."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=True)
    site = next(home.glob("lib/python*/site-packages"), home / "Lib" / "site-packages")
    (site / "outer.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n")
    path = os.pathsep.join([str(home / ("Scripts" if sys.platform == "win32" else "bin")), os.environ["PATH"]])
    return os.environ | {"PATH": path, "VIRTUAL_ENV": str(home), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


@pytest.mark.slow
def test_the_page_from_an_empty_folder_to_a_row_of_compare(environment: dict[str, str], tmp_path: Path):
    output = ""
    for step in STEP.finditer(PAGE.read_text()):
        if step["file"]:
            (tmp_path / step["file"]).write_text(step["body"])
            continue
        assert step["language"] == "sh"
        for line in step["body"].splitlines():
            done = subprocess.run(
                line, shell=True, check=False, cwd=tmp_path, env=environment, capture_output=True, text=True
            )
            assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
            output += done.stdout
    assert re.search(r"evolution +stereorecal-evolution +0\.1\.0 +host +Evolution \(1 \+ lambda\)", output)
    assert re.search(r"^\[0\.\d+ +0\.\d+ *\] 0\.9\d+ (CONVERGED|BUDGET) \d+\.0$", output, re.MULTILINE)
    assert "pass  repairs a stereo rig" in output
    assert "FAIL" not in output
    assert re.search(r"\d+ passed", output)
    assert re.search(r"evolution +\d+ % ", output)  # its row in the summary
