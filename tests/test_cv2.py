"""An OpenCV that is not there, in part or too old is said in one sentence."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

REMEDY = "pip install --force-reinstall opencv-python-headless"


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "OpenCV was removed in part"),
        ("__version__ = '4.12.0'", "OpenCV 4.12.0 is too old: it must be 4.13 or newer"),
        ("__version__ = '3.4.18-dev'", "OpenCV 3.4.18-dev is too old"),
        ("raise ImportError('libGL.so.1: no such file')", "OpenCV cannot be imported (libGL.so.1: no such file)"),
    ],
)
@pytest.mark.parametrize(
    "command", [("-c", "import stereorecal as sr; sr.Pair"), ("-m", "stereorecal", "diff", __file__, __file__)]
)
def test_one_sentence(tmp_path: Path, content: str, words: str, command: tuple[str, ...]):
    (tmp_path / "cv2").mkdir()
    (tmp_path / "cv2" / "__init__.py").write_text(content)
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": path}
    done = subprocess.run([sys.executable, *command], env=environment, capture_output=True, text=True, check=False)
    last = done.stderr.strip().splitlines()[-1]
    assert words in last
    assert REMEDY in last
    if "-m" in command:
        assert done.returncode == 2
        assert done.stderr == f"stereorecal: {last.removeprefix('stereorecal: ')}\n"
