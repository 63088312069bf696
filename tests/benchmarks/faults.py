"""Faults injected while files are written: is a user's file ever lost or half, is a finished result ever unsaid?

`recalibrate --in-place`, `compare --json --html` and `reproduce` run as processes of their own. In each run one thing
goes wrong: the n-th call that writes fails as on a full disk, or the process is sent kill -9, Ctrl-C, SIGTERM or SIGHUP
at one of many moments. Then every file that was there must be as it was or complete, every JSON must be readable, no
traceback may have been printed, a signal must end in 130 (or in the run's own code, if it had just finished), and a
second `reproduce` must go on.

    python tests/benchmarks/faults.py [--moments 50] [--writes 12] [--verbs in-place,compare,reproduce]
"""

import argparse
import collections
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io import load_rig, save_scene
from stereorecal.synthetic import default_rig, render

_STARTED = 0.4  # seconds that Python itself needs before the first line of the program
SIGNALS = [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP]

# In the child: the n-th call of these fails. Files of libraries and caches are left alone.
FAILING = """
import builtins, errno, os, signal, sys
for name in ("SIGINT", "SIGTERM", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
left, folder = int(sys.argv[1]), sys.argv[2]

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

if left:
    builtins.open = failing(open, ours)
    import io
    io.open = failing(io.open, ours)
    os.fsync = failing(os.fsync, lambda *_: True)
    os.replace = failing(os.replace, lambda one, other: str(other).startswith(folder))
from stereorecal.__main__ import run
sys.argv = ["stereorecal", *sys.argv[3:]]
run()
"""


def made_scene(folder: Path) -> None:
    """A small scene whose rig has drifted."""
    scene = render("harbour", 0, rig=default_rig().resized((160, 120)))
    assert scene.rig is not None
    drift = np.array([*np.radians([0.8, 0.3, -0.9]), 0.0, 0.003, -0.003])
    save_scene(replace(scene, rig=scene.rig.with_extrinsics(scene.rig.extrinsics + drift), reference="stored"), folder)


def words_of(verb: str, scene: Path, folder: Path) -> list[str]:
    count = ["--schedule", "count"]
    out, page = str(folder / "out.json"), str(folder / "out.html")
    match verb:
        case "in-place":
            more = ["--in-place", "--json", out, "--maps", str(folder / "out.npz")]
            return ["recalibrate", str(scene), *count, "--scale", "0.5", "--budget", "40", *more]
        case "compare":
            few = ["--scale", "0.25", "--draws", "3", "--budget", "4"]
            return ["compare", "--scene", str(scene), *count, *few, "--json", out, "--html", page]
        case _:
            few = ["--quick", *count, "--output", str(folder / "made")]
            return ["reproduce", "ex-nihilo", "--log", str(scene), *few]


def wrong(verb: str, folder: Path, before: dict[str, bytes], said: str, code: int, fault: str) -> list[str]:
    """What should not be as it is."""
    found = []
    if "Traceback" in said or "internal error" in said:
        found.append(f"said: {said[-500:]}")
    for name, data in before.items():
        path = folder / name
        if not path.exists():
            found.append(f"{name} is lost")
        elif path.read_bytes() != data and not (verb == "in-place" and name == "scene/calib.json"):
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
    if fault == "write" and code == 2 and verb != "reproduce" and "medians" not in said and "accepted" not in said:
        found.append(f"a finished result is unsaid: {said[-300:]}")
    return found


def one(
    verb: str,
    folder: Path,
    fail: int = 0,
    number: signal.Signals | None = None,
    after: float = 0.0,
    goes_on: bool = False,
) -> tuple:
    """Run with one fault: exit code, seconds, and what is wrong."""
    scene = folder / "scene"
    before = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in (scene if goes_on else folder).rglob("*")
        if path.is_file()
    }
    words = [sys.executable, "-c", FAILING, str(fail), str(folder), *words_of(verb, scene, folder)]
    began = time.monotonic()
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        if number is not None:
            try:
                process.wait(after)
            except subprocess.TimeoutExpired:
                process.send_signal(number)
        said = process.communicate(timeout=300)[0]
    fault = number.name if number else "write" if fail else "none"
    return process.returncode, time.monotonic() - began, wrong(verb, folder, before, said, process.returncode, fault)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=50, help="of each signal and each verb")
    parser.add_argument("--writes", type=int, default=12, help="the first so many are made to fail, one in a run")
    parser.add_argument("--verbs", default="in-place,compare,reproduce")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        good = Path(name) / "good"
        made_scene(good)
        for verb in options.verbs.split(","):
            codes, bad = collections.Counter(), 0

            def tried(about: str, verb: str = verb, codes: collections.Counter = codes, **fault) -> tuple:
                folder = Path(tempfile.mkdtemp(dir=name))
                shutil.copytree(good, folder / "scene")
                code, seconds, found = one(verb, folder, **fault)
                codes[f"{about.partition(' ')[0]}: {code}"] += 1
                if verb == "reproduce" and fault:
                    again, _, more = one(verb, folder, goes_on=True)
                    found += more + ([f"does not go on: exit code {again}"] if again not in (0, 1) else [])
                for line in found:
                    print(f"  {verb}, {about}: {line}", flush=True)
                shutil.rmtree(folder)
                return seconds, bool(found)

            tried("none")
            seconds, _ = tried("none")  # now that all is compiled
            for number in SIGNALS:
                for moment in np.linspace(_STARTED, seconds, options.moments):
                    bad += tried(f"{number.name} after {moment:.2f} s", number=number, after=moment)[1]
            for fail in range(1, options.writes + 1):
                bad += tried(f"write {fail} fails", fail=fail)[1]
            print(f"{verb} ({seconds:.1f} s): {dict(sorted(codes.items()))}, wrong: {bad}", flush=True)


if __name__ == "__main__":
    main()
