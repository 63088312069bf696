"""Pages of the command line: what is refused without the extra, and what is written."""

import html
import json
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("missing", [("jinja2", "markupsafe"), ("matplotlib",)])
def test_without_the_extra(command, unworked, clean_scene: Path, tmp_path: Path, monkeypatch, missing: tuple[str, ...]):
    for name in missing:
        monkeypatch.setitem(sys.modules, name, None)
    for name in [name for name in sys.modules if name.startswith("stereorecal.report.")]:
        monkeypatch.delitem(sys.modules, name)
    answer = command("recalibrate", clean_scene, *unworked, "--html", tmp_path / "out.html")
    answer.refuses(f"--html needs {missing[0]}, which is not installed; run: pip install 'stereorecal[figures]'\n")


def test_a_repair_says_how_to_run_it_again(command, clean_scene: Path, tmp_path: Path):
    """Pasted into a shell, names with blanks, quotes and markup stay one word each."""
    scene = tmp_path / "a 'rig' <b>$HOME"
    shutil.copytree(clean_scene, scene)
    words = ["recalibrate", scene, "--html", tmp_path / "out page.html", "--reach", "2,0.02", "--schedule", "count"]
    command(*words)
    page = (tmp_path / "out page.html").read_text(encoding="utf-8")
    (shown,) = re.findall(r'<pre class="command"[^>]*>(.*?)</pre>', page, flags=re.DOTALL)
    assert shlex.split(html.unescape(shown)) == ["python", "-m", "stereorecal", *map(str, words)]
    (shown,) = re.findall(r'aria-label="Settings and versions">(.*?)</pre>', page, flags=re.DOTALL)
    settings = json.loads(html.unescape(shown))
    assert (settings["seed"], settings["reach"]) == (0, {"degrees": 2.0, "baseline_fraction": 0.02})
    assert (settings["ranges"], settings["free"]) == ("none", "everything")
    assert "stereorecal-compass" in settings["stages"][0]["origin"]
