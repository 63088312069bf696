"""Does what is handed out work where there is no checkout? Builds, installs and runs; prints what took how long.

    pip install build
    python tests/benchmarks/wheels.py

Builds the source distribution of the library and of every plug-in, from it the wheel, installs `stereorecal[all]` from
the folder of wheels into a new environment, and there, in an empty folder, follows what a new user does: render a
scene, look, repair, compare with plug-ins, write a page. It takes some minutes, most of them for what pip fetches.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
# What needs a compiler is left out.
PROJECTS = (
    ROOT,
    *sorted(
        path.parent for path in ROOT.glob("plugins/*/pyproject.toml") if not path.with_name("CMakeLists.txt").exists()
    ),
)

RENDER = """
import sys
from pathlib import Path
import jax, numpy as np, stereorecal as sr
from dataclasses import replace

assert Path(sr.__file__).is_relative_to(sys.prefix), sr.__file__
truth = sr.synthetic.default_rig().resized((320, 240))
scene = sr.synthetic.render("street", 3, rig=truth)
bad = sr.synthetic.decalibrate(truth, jax.random.key(7), 0.5, 0.01)
sr.io.save_scene(replace(scene, rig=bad, reference="stored"), "scene")
"""

LOOK = """
import json
(repair,) = json.load(open("repair.json"))["repairs"]
assert repair["accepted"], repair["verdict"]
trials = json.load(open("table.json"))["trials"]
assert all(trial["status"] not in ("FAILED", "SKIPPED") for trial in trials), trials
assert "<html" in open("table.html").read()
"""

COMPARE = """-m stereorecal compare --scene scene --schedule count --scale 0.5 --draws 1 --budget 40
    --strategies compass,nlopt-bobyqa,optimistix-gradient-descent,features --json table.json --html table.html"""


def main() -> int:
    """Build, install, run."""
    with tempfile.TemporaryDirectory() as scratch:
        home = Path(scratch).resolve()
        dist, empty = home / "dist", home / "empty"
        dist.mkdir()
        empty.mkdir()
        for words, expected in steps(home, dist):
            began = time.perf_counter()
            done = run(words, empty)
            told = " ".join(Path(word).name if os.sep in word else word for word in words)
            print(f"{time.perf_counter() - began:6.1f} s  {told.splitlines()[0][:100]}", flush=True)
            if done.returncode not in expected:
                print(done.stdout, done.stderr, sep="\n")
                return 1
        for path in sorted(dist.iterdir()):
            print(f"{path.stat().st_size / 1024:6.0f} KiB  {path.name}")
    return 0


def steps(home: Path, dist: Path) -> Iterator[tuple[list[str], tuple[int]]]:
    """Commands, with the exit codes that are right."""
    good = (0,)
    for project in PROJECTS:
        yield [sys.executable, "-m", "build", "--outdir", str(dist), str(project)], good
    yield [sys.executable, "-m", "venv", str(home / "venv")], good
    inside = str(home / "venv" / "bin" / "python")

    folder = ["--find-links", str(dist)]  # beside the index, which has what is not ours
    yield [inside, "-m", "pip", "install", "--quiet", *folder, "stereorecal[all]"], good
    yield [inside, "-m", "pip", "check"], good
    for words, expected in (
        (["-c", RENDER.strip()], good),
        (["-m", "stereorecal", "--version"], good),
        (["-m", "stereorecal", "strategies"], good),
        (["-m", "stereorecal", "score", "scene"], (1,)),  # repair it
        (["-m", "stereorecal", "recalibrate", "scene", "--json", "repair.json", "--output", "repaired.json"], good),
        (["-m", "stereorecal", "diff", "scene", "repaired.json"], good),
        (COMPARE.split(), good),
        (["-c", LOOK.strip()], good),
    ):
        yield [inside, "-W", "error::DeprecationWarning:stereorecal", *words], expected


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """In the empty folder, and without what this shell knows of the checkout."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)


if __name__ == "__main__":
    sys.exit(main())
