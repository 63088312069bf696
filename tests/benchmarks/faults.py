"""Faults injected while files are written: is a user's file ever lost or half, is a finished result ever unsaid?

`recalibrate` over its own calibration, `compare --json --html` and `reproduce` run as processes, forked from one that
has imported the libraries (what signals do before that, tests/cli/test_signals.py tells). In each run one thing goes
wrong: the n-th call that writes fails as on a full disk, or the process is sent kill -9, Ctrl-C, SIGTERM or SIGHUP at
one of many moments. Then every file that was there must be as it was or complete, every JSON must be readable, no
traceback may have been printed, a signal must end in 130 (or in the run's own code, if it had just finished), and a
second `reproduce` must go on, and end with the rows of one that nothing disturbed.

Moments lie evenly over the length of a run; they are tried in an order in which they are spread evenly whenever the
time of --minutes is up, verbs and signals in turn, and what was tried is said.

    python tests/benchmarks/faults.py [--moments 50] [--writes 12] [--minutes 60]
"""

import collections
import contextlib
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from tables import command_line

from stereorecal import InputError
from stereorecal.io import load_rig, save_scene
from stereorecal.synthetic import default_rig, render

SIGNALS = [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP]

# A process that has imported everything, and forks for each line of stdin, which names the number of the call that is
# to fail (0: none), the folder that is the user's, and the words of the command. Files of libraries and caches are left
# alone. It says the child's id, and once that has ended its exit code, minus the signal if one killed it.
ZYGOTE = """
import builtins, errno, io, json, os, signal, sys
import cv2, jax, matplotlib.figure, numpy
import stereorecal.cli._compare, stereorecal.cli._recalibrate, stereorecal_paper._command
from stereorecal.__main__ import run
from stereorecal.cli._signals import end_at_once
from stereorecal.strategies import strategies
strategies()
for name in ("SIGINT", "SIGTERM", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
end_at_once()  # the first that a command does; children have it from here

def failing(function, watched):
    def call(*arguments, **options):
        global left
        if watched(*arguments, **options):
            left -= 1
            if left == 0:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return function(*arguments, **options)
    return call

def ours(path, mode="r", *_, **__):
    return str(path).startswith(folder) and any(sign in mode for sign in "wxa+")

for line in sys.stdin:
    left, folder, words = json.loads(line)
    child = os.fork()
    if child:
        print(child, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        continue
    said = os.open(folder + ".said", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    if left:
        builtins.open = failing(open, ours)
        io.open = failing(io.open, ours)
        os.fsync = failing(os.fsync, lambda *_: True)
        os.replace = failing(os.replace, lambda one, other: str(other).startswith(folder))
    sys.argv = ["stereorecal", *words]
    try:
        run()
    except SystemExit as end:
        sys.stdout.flush()
        os._exit(end.code or 0)
    finally:
        os._exit(99)
"""


class Zygote:
    """Starts commands without waiting for the libraries."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", ZYGOTE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, fail: int, folder: Path, words: list[str], number: signal.Signals | None, after: float) -> tuple:
        """Exit code, what was said, seconds."""
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        Path(f"{folder}.said").touch()
        process.stdin.write(json.dumps([fail, str(folder), words]) + "\n")
        process.stdin.flush()
        child, began = int(process.stdout.readline()), time.monotonic()
        if number is not None and not select.select([process.stdout], [], [], after)[0]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, number)
        code = int(process.stdout.readline())
        said = Path(f"{folder}.said").read_text()
        return code, said, time.monotonic() - began


def made_scene(folder: Path, frames: int) -> None:
    """A small scene whose rig has drifted."""
    scene = render("harbour", 0, rig=default_rig().resized((160, 120)), frames=frames)
    assert scene.rig is not None
    drift = np.array([*np.radians([0.8, 0.3, -0.9]), 0.0, 0.003, -0.003])
    save_scene(replace(scene, rig=scene.rig.with_extrinsics(scene.rig.extrinsics + drift), reference="stored"), folder)


def words_of(verb: str, scene: Path, folder: Path) -> list[str]:
    count = ["--schedule", "count"]
    out, page = str(folder / "out.json"), str(folder / "out.html")
    match verb:
        case "recalibrate":
            own = ["--output", str(scene / "calib.json"), "--force"]
            return ["recalibrate", str(scene), *count, *own, "--json", out, "--maps", str(folder / "out.npz")]
        case "compare":
            few = ["--scale", "0.25", "--draws", "3", "--budget", "4"]
            return ["compare", "--scene", str(scene), *count, *few, "--json", out, "--html", page]
        case _:
            few = ["--quick", *count, "--output", str(folder / "made")]
            return ["reproduce", "validity", "ex-nihilo", "--log", str(scene.with_name("log")), *few]


def wrong(verb: str, folder: Path, before: dict[str, bytes], said: str, code: int, fault: str) -> list[str]:
    """What should not be as it is."""
    found = []
    if "Traceback" in said or "internal error" in said:
        found.append(f"said: {said[-500:]}")
    for name, data in before.items():
        path = folder / name
        if not path.exists():
            found.append(f"{name} is lost")
        elif path.read_bytes() != data and not (verb == "recalibrate" and name == "scene/calib.json"):
            found.append(f"{name} has changed")
    try:
        load_rig(folder / "scene" / "calib.json")
    except InputError as error:
        found.append(str(error))
    for path in folder.rglob("*.json"):
        try:
            json.loads(path.read_text())
        except ValueError:
            found.append(f"{path.name} is no JSON")
    for path in folder.rglob("*.html"):
        if "</html>" not in path.read_text():
            found.append("the page is cut")
    changed = (folder / "scene/calib.json").read_bytes() != before["scene/calib.json"]
    if changed and (folder / "scene/calib.json.bak").read_bytes() != before["scene/calib.json"]:
        found.append("no copy of the calibration that was replaced")
    if fault in ("SIGINT", "SIGTERM", "SIGHUP") and code not in (130, 0, 1):
        found.append(f"exit code {code}: {said[-300:]}")
    if fault == "write" and code not in (0, 1, 2):
        found.append(f"exit code {code}: {said[-300:]}")
    if fault == "write" and code == 2 and verb != "reproduce" and "medians" not in said and "Repaired" not in said:
        found.append(f"a finished result is unsaid: {said[-300:]}")
    return found


def rows_of(folder: Path) -> object:
    """What `reproduce` found, but for the time that it took."""

    def timeless(value: object) -> object:
        if isinstance(value, dict):
            return {key: timeless(item) for key, item in value.items() if key != "seconds"}
        return [timeless(item) for item in value] if isinstance(value, list) else value

    return [
        timeless(json.loads(path.read_text().replace(folder.name, ""))["rows"])
        for path in sorted((folder / "made").glob("*[a-z].json"))
        if path.name != "settings.json"
    ]


def spread(number: int) -> list[float]:
    """Fractions from 0 to 1, evenly spaced, in an order whose beginning is spread as well."""
    return [x for _, x in sorted((int(f"{i:010b}"[::-1], 2), x) for i, x in enumerate(np.linspace(0.0, 1.0, number)))]


def one(
    zygote: Zygote,
    verb: str,
    folder: Path,
    fail: int = 0,
    number: signal.Signals | None = None,
    after: float = 0.0,
) -> tuple:
    """Run with one fault: exit code, seconds, and what is wrong."""
    scene = folder / "scene"
    before = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and "made" not in path.parts
    }
    code, said, seconds = zygote.run(fail, folder, words_of(verb, scene, folder), number, after)
    fault = number.name if number else "write" if fail else "none"
    return code, seconds, wrong(verb, folder, before, said, code, fault)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--moments", type=int, default=50, help="of each signal and each verb")
    parser.add_argument("--writes", type=int, default=12, help="the first so many are made to fail, one in a run")
    parser.add_argument("--minutes", type=float, default=60.0, help="no run begins later")
    options = parser.parse_args()
    verbs, began, zygote = ("recalibrate", "compare", "reproduce"), time.monotonic(), Zygote()
    with tempfile.TemporaryDirectory() as name:
        good = Path(name) / "good"
        made_scene(good / "scene", 1)
        made_scene(good / "log", 3)
        codes = {verb: collections.Counter() for verb in verbs}
        bad, length, expected = collections.Counter(), {}, []

        def tried(verb: str, about: str, **fault) -> float:
            folder = Path(tempfile.mkdtemp(dir=name))
            shutil.copytree(good, folder, dirs_exist_ok=True)
            code, seconds, found = one(zygote, verb, folder, **fault)
            codes[verb][f"{about.partition(' ')[0]}: {code}"] += 1
            if verb == "reproduce" and fault:
                again, _, more = one(zygote, verb, folder)
                found += more + ([f"does not go on: exit code {again}"] if again else [])
                found += [] if rows_of(folder) == expected else ["goes on to other rows"]
            elif verb == "reproduce":
                expected[:] = rows_of(folder)
            for line in found:
                print(f"  {verb}, {about}: {line}", flush=True)
            bad[verb] += bool(found)
            shutil.rmtree(folder)
            Path(f"{folder}.said").unlink()
            return seconds

        for verb in verbs:
            tried(verb, "none")
            length[verb] = tried(verb, "none")  # now that all is compiled
        writes = [("write", fail) for fail in range(1, options.writes + 1)]
        for kind, what in [*writes, *((number, share) for share in spread(options.moments) for number in SIGNALS)]:
            for verb in verbs:
                if time.monotonic() - began > 60 * options.minutes:
                    break
                if kind == "write":
                    tried(verb, f"write {what} fails", fail=what)
                else:
                    after = what * length[verb]
                    tried(verb, f"{kind.name} after {after:.2f} s", number=kind, after=after)
        for verb in verbs:
            print(f"{verb} ({length[verb]:.1f} s): {dict(sorted(codes[verb].items()))}, wrong: {bad[verb]}", flush=True)


if __name__ == "__main__":
    main()
