"""Which versions does it run with? Runs tests in environments of their own and prints a table.

    pip install uv
    python tests/benchmarks/versions.py [CASE …] [--python PATH …] [--tests PATH …] [--keep FOLDER]

Cases: `lowest` and `highest` of each requirement of the library, its extras and the plug-ins in this repository;
`opencv-python`, `opencv-contrib-python` (highest), alone or after `@` in a version, in place of the headless one; any
requirement, such as `jax==0.9.2`, with the highest of all others. A case may join several with a plus sign. Default:
`lowest`, `highest`, and OpenCV's other distributions. --python: interpreters; default this one. --tests: what pytest is
given; default a few minutes' choice, `--tests tests plugins docs` is the suite.
"""

import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tables import command_line, show, table_of
from wheels import PROJECTS, ROOT

EXTRAS = ("dask", "figures")  # what people use; the tools of the tests are taken as they are today
TOOLS = ("beartype", "flit_core", "hatchling", "hypothesis", "pytest", "pytest-xdist", "sybil")
CASES = (
    "lowest",
    "highest",
    "opencv-python@4",
    "opencv-python@5",
    "opencv-contrib-python@4",
    "opencv-contrib-python@5",
)
CHOICE = (
    "tests/geometry",
    "tests/io",
    "tests/matching",
    "tests/strategies",
    "tests/scoring/test_pure.py",
    "tests/scoring/test_score.py",
    "tests/cli/test_diff.py",
    "tests/cli/test_score.py",
    "tests/recalibration/test_default_schedule.py",
    "tests/test_imports.py",
    "tests/test_compile_cache.py",
    "plugins/boards",
    "plugins/compass",
    "plugins/colmap",
    "plugins/features",
    "plugins/levenberg-marquardt",
    "plugins/nlopt",
    "plugins/optimistix",
    "plugins/paper",
)
PLAIN = "--import-mode=importlib"  # without the check of types, which older versions of its tools cannot do
TOLD = ("jax", "numpy", "scipy", "opencv", "optimistix", "nlopt")  # in the table


@dataclass(frozen=True)
class Result:
    """One line of the table."""

    case: str
    python: str
    versions: str
    ended: str


def main() -> int:
    """Build, run, show; fails if a case does."""
    parser = command_line(__doc__)
    parser.add_argument("cases", nargs="*", default=CASES)
    parser.add_argument("--python", nargs="+", default=[sys.executable])
    parser.add_argument("--tests", nargs="+", default=CHOICE)
    parser.add_argument("--keep", type=Path, help="folder in which environments stay and what pytest said is written")
    options = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as scratch:
        home = (options.keep or Path(scratch)).resolve()
        home.mkdir(parents=True, exist_ok=True)
        for python in options.python:
            for case in options.cases:
                results.append(tried(case, python, options.tests, home))
                print(*vars(results[-1]).values(), sep=" | ", flush=True)
    table = table_of("case | Python | with | ended", left=4)
    for result in results:
        table.add_row(*vars(result).values())
    show(table)
    return int(any("passed" not in result.ended or "failed" in result.ended for result in results))


def requirements(case: str) -> tuple[list[str], str]:
    """What is asked for in a case, and with which resolution."""
    wanted: list[str] = []
    for project in PROJECTS:
        content = tomllib.loads((project / "pyproject.toml").read_text())["project"]
        extras = content.get("optional-dependencies", {})
        wanted += content["dependencies"] + [line for name in EXTRAS for line in extras.get(name, ())]
    wanted = [line for line in wanted if not line.startswith("stereorecal")]
    parts = case.split("+")
    for part in parts:
        if part.startswith("opencv"):
            name, _, version = part.partition("@")
            wanted = [line for line in wanted if not line.startswith("opencv")]
            wanted.append(f"{name}=={version}.*" if version else name)
        elif part not in ("lowest", "highest"):
            wanted.append(part)
    return wanted, "lowest-direct" if "lowest" in parts else "highest"


def tried(case: str, python: str, tests: Sequence[str], home: Path) -> Result:
    """An environment for a case, and how the tests ended there."""
    wanted, resolution = requirements(case)
    folder = home / re.sub(r"[^\w.]+", "-", f"{case}-{Path(python).resolve().parent.parent.name}")
    inside = folder / "bin" / "python"
    said = uv("venv", "--clear", "--python", python, folder)
    pins = folder / "pins.txt"
    steps = (
        ("pip", "compile", "--resolution", resolution, "--python", inside, "--output-file", pins, "-"),
        ("pip", "install", "--python", inside, "--requirement", pins, *TOOLS),
        ("pip", "install", "--python", inside, "--no-deps", *(w for p in PROJECTS for w in ("--editable", p))),
    )
    for step in steps:
        said = said if said.returncode else uv(*step, given="\n".join(wanted))
    if said.returncode:
        return Result(case, python, "", said.stderr.strip().splitlines()[-1])
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = (inside, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", f"addopts={PLAIN}", *tests)
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    (folder / "pytest.txt").write_text(done.stdout + done.stderr)
    last = (done.stdout.strip() or done.stderr.strip() or "nothing was said").splitlines()[-1]
    return Result(case, version_of(inside), installed(inside), last.strip("= "))


def uv(*words: object, given: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "uv", *map(str, words), "--quiet"]
    return subprocess.run(command, cwd=ROOT, input=given, capture_output=True, text=True, check=False)


def version_of(python: Path) -> str:
    """The version of the interpreter."""
    return subprocess.run([python, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]


def installed(python: Path) -> str:
    """The versions that matter most, as installed."""
    lines = uv("pip", "freeze", "--python", python).stdout.splitlines()
    return ", ".join(line.replace("==", " ") for line in lines if line.startswith(TOLD) and "jaxt" not in line)


if __name__ == "__main__":
    sys.exit(main())
