"""Damaged files by the thousand: does any end the process, escape as a traceback, hang, or eat the memory?

Files of every format, of every layout, images, videos, bags and saved states are flipped, cut, repeated, filled and
nested at places that a seed chooses, and read. A child process does the reading, with a limit on memory and on time;
where it dies, the seed is noted and the next child goes on. Printed: how many were read, how many were refused, and
what went wrong.

    python tests/benchmarks/fuzz.py [--inputs 100000] [--only NAME,…]
"""

import argparse
import collections
import contextlib
import io
import json
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS), str(TESTS / "io" / "formats"), str(TESTS.parent / "plugins" / "field" / "tests")]

from bags import write_bag  # noqa: E402  beside this suite's tests
from damage import damaged  # noqa: E402
from every import SAMPLES  # noqa: E402
from field_trees import FIELD_TREES  # noqa: E402
from tables import among, command_line, words  # noqa: E402
from test_matrices_under_any_names import D1, D2, K1, K2, R, T  # noqa: E402
from test_read_only_forms import FORMS  # noqa: E402
from trees import TREES  # noqa: E402

from stereorecal import online  # noqa: E402
from stereorecal._errors import InputError  # noqa: E402
from stereorecal.io import (  # noqa: E402
    load_log,
    load_pair,
    load_ranges,
    load_rig,
    load_scene,
    open_pairs,
    save_rig,
    save_scene,
)
from stereorecal.recordings import Pair  # noqa: E402
from stereorecal.synthetic import default_rig, render  # noqa: E402

MEGABYTES, SECONDS = 1000, 20  # more than these is too much
ENDINGS = (".png", ".jpg", ".tif", ".bmp", ".pgm", ".webp", ".jp2")
CODECS = {".avi": "MJPG", ".mp4": "mp4v"}
SIDES = ("left", "right")
TOPICS = {"left_topic": "/left", "right_topic": "/right"}


@dataclass(frozen=True)
class Case:
    """Files to be damaged, by path below a folder, and what reads them."""

    files: dict[str, bytes]
    read: Callable[[Path], Any]


def cases(folder: Path) -> dict[str, Case]:
    """Everything that is read, undamaged."""
    found = {}
    for name, sample in SAMPLES.items():
        place = folder / name
        place.mkdir()
        paths = [path.name for path in sample.write(place)]
        found[name] = Case(
            files_of(place), lambda at, paths=paths, s=sample: load_rig(*(at / p for p in paths), size=s.size)
        )
    for name, make in (FORMS | {"npz": npz, "texts": texts}).items():
        place = folder / f"form {name}"
        place.mkdir()
        paths = [path.name for path in make(place)]
        found[f"form {name}"] = Case(
            files_of(place), lambda at, paths=paths: load_rig([at / p for p in paths], size=(640, 480))
        )
    rig = default_rig().resized((160, 120))
    scene = render("harbour", 0, rig=rig, frames=3)
    save_scene(scene, folder / "scene")
    found["scene folder"] = Case(files_of(folder / "scene"), lambda at: load_scene(at))
    for name in ("depthai", "stereorecal"):
        save_rig(rig, folder / f"{name}.json", format=name)
        found[name] = Case({"a.json": (folder / f"{name}.json").read_bytes()}, lambda at: load_rig(at / "a.json"))
    for name, make in (TREES | FIELD_TREES).items():
        (folder / f"tree {name}").mkdir()
        make(folder / f"tree {name}")
        found[f"layout {name}"] = Case(files_of(folder / f"tree {name}"), read_log)
    for ending in ENDINGS:
        sides = [
            cv2.imencode(ending, np.uint8(side))[1].tobytes() for side in (scene.pairs[0].left, scene.pairs[0].right)
        ]
        files = {f"{side}{ending}": data for side, data in zip(("left", "right"), sides, strict=True)}
        found[f"image {ending}"] = Case(files, lambda at, e=ending: load_pair(at / f"left{e}", at / f"right{e}"))
    sides = [[np.uint8(pair.left), np.uint8(pair.right)] for pair in scene.pairs]
    for ending, codec in CODECS.items():
        write_video(folder / f"both{ending}", codec, [np.hstack(pair) for pair in sides])
        files = {f"both{ending}": (folder / f"both{ending}").read_bytes()}
        found[f"video {ending}"] = Case(files, lambda at, e=ending: read_all(open_pairs(at / f"both{e}").pairs))
    for name, ros1, compressed in (
        ("drive.bag", True, False),
        ("drive", False, False),
        ("drive compressed", False, True),
    ):
        stamped = [(f"/{side}", i * 10**8, pair[k]) for i, pair in enumerate(sides) for k, side in enumerate(SIDES)]
        write_bag(folder / name, stamped, ros1=ros1, compressed=compressed)
        files = {name: (folder / name).read_bytes()} if ros1 else files_of(folder / name)
        inside = name if ros1 else "."
        found[f"bag {name}"] = Case(files, lambda at, n=inside: read_all(open_pairs(at / n, **TOPICS).pairs))
    online.save(online.init(rig), folder / "kept.state")
    found["state"] = Case(
        {"kept.state": (folder / "kept.state").read_bytes()}, lambda at: online.load(at / "kept.state")
    )
    table = b"pair,column,row,metres,sigma\n0,20,30,10.5,0.1\n0,21,30,inf,\n"
    found["ranges"] = Case({"ranges.csv": table}, lambda at: load_ranges(at / "ranges.csv"))
    return found


def npz(folder: Path) -> list[Path]:
    np.savez(folder / "a.npz", mtx_l=K1, dist_l=D1, mtx_r=K2, dist_r=D2, R=R, T=T)
    return [folder / "a.npz"]


def texts(folder: Path) -> list[Path]:
    for name, value in (("K_l", K1), ("d_l", D1), ("K_r", K2), ("d_r", D2), ("R", R), ("T", T)):
        np.savetxt(folder / f"{name}.txt", value)
    return sorted(folder.iterdir())


def read_log(folder: Path) -> None:
    """With all its images, which are read when they are asked for."""
    for mission in load_log(folder).missions:
        read_all(mission.pairs)


def read_all(pairs: Iterable[Pair]) -> None:
    """One after the other."""
    for _ in pairs:
        pass


def write_video(path: Path, codec: str, images: Sequence[np.ndarray]) -> None:
    height, width = images[0].shape
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), 10.0, (width, height), isColor=False)
    for image in images:
        writer.write(image)
    writer.release()


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def work(first: int, last: int, only: str, journal: Path) -> None:
    """In the child: read the inputs of these seeds; a line for each into the journal."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        (scratch / "good").mkdir()
        known = cases(scratch / "good")
        kinds = [kind for kind in known if among(kind, words(only))]
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + MEGABYTES * 2**20,) * 2)
        signal.signal(signal.SIGALRM, too_slow)
        with open(journal, "a", buffering=1) as log:
            for seed in range(first, last):
                random = np.random.default_rng(seed)
                kind = kinds[random.integers(len(kinds))]
                case = known[kind]
                log.write(json.dumps([seed, kind, "begun"]) + "\n")
                place = scratch / "bad"
                target = list(case.files)[random.integers(len(case.files))]
                for path, data in case.files.items():
                    (place / path).parent.mkdir(parents=True, exist_ok=True)
                    (place / path).write_bytes(damaged(data, random) if path == target else data)
                signal.alarm(SECONDS)
                log.write(json.dumps([seed, kind, outcome(case, place)]) + "\n")
                signal.alarm(0)
                shutil.rmtree(place)


def outcome(case: Case, place: Path) -> str:
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            case.read(place)
    except InputError as error:
        return "refused" if "\n" not in str(error) else "refused in several lines"
    except MemoryError:
        return "memory"
    except TimeoutError:
        return "time"
    except Exception as error:
        return f"traceback: {error!r:.200}"
    return "read"


def too_slow(*_: object) -> None:
    raise TimeoutError


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--only", default="", help="parts of names of kinds, comma separated")
    parser.add_argument("--child", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        first, last, journal = options.child
        work(int(first), int(last), options.only, Path(journal))
        return
    journal, next_one = Path(tempfile.mkdtemp()) / "journal.jsonl", 0
    began, deaths, peak = time.monotonic(), collections.Counter(), 0
    journal.write_text("")
    while next_one < options.inputs:
        seeds = map(str, (next_one, min(next_one + 5000, options.inputs)))
        command = [sys.executable, __file__, "--only", options.only, "--child", *seeds, str(journal)]
        child = subprocess.run(command, check=False, stderr=subprocess.DEVNULL)
        peak = max(peak, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
        entries = [json.loads(line) for line in journal.read_text().splitlines()]
        if child.returncode:
            if not entries or entries[-1][2] != "begun":
                raise SystemExit("the child cannot begin")
            deaths[f"{entries[-1][1]}: exit {child.returncode}, seed {entries[-1][0]}"] += 1
        next_one = entries[-1][0] + 1
    found = collections.Counter(entry[2].partition(":")[0] for entry in entries if entry[2] != "begun")
    print(f"{options.inputs} inputs in {time.monotonic() - began:.0f} s, peak {peak / 1024:.0f} MB: {dict(found)}")
    print(f"processes that died: {sum(deaths.values())}", *deaths, sep="\n  ")
    for seed, kind, said in (entry for entry in entries if entry[2] not in ("begun", "read", "refused")):
        print(f"  seed {seed}, {kind}: {said}")


if __name__ == "__main__":
    main()
