"""The shell lines of tutorials and what they print, in the folder that their first block makes. (Blocks of Python are
run where the pages are.)"""

import re
import shlex
from pathlib import Path

import pytest
from printed_output import agrees

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"


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
def test_shell_lines(command, page: str, written: list[str], monkeypatch: pytest.MonkeyPatch):
    text = (TUTORIALS / page).read_text()
    names: dict[str, Path] = {}
    exec(re.findall(r"```python\n(.*?)```", text, re.DOTALL)[0], names)
    monkeypatch.chdir(names["folder"])
    before = set(names["folder"].iterdir())
    blocks = re.findall(r"```sh\n(.*?)```\n\n```output\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == text.count("```sh\n") > 0
    for lines, shown in blocks:
        printed = ""
        for line in lines.splitlines():
            assert line.startswith("python -m stereorecal ")
            answer = command(*shlex.split(line)[3:])
            assert (answer.code, answer.err) == (0, ""), line
            printed += answer.out
        assert agrees(shown, printed), printed
    found = sorted(path.name for path in {*names["folder"].iterdir()} - before)
    assert [name for name in found if not name.endswith(".prior.json")] == written  # what is known lies beside each
