"""How long does one wait: for an import, a command, the first repair and the next? Prints one table.

    python tests/benchmarks/start_up.py [--rounds N]

Whole processes are timed in turn with `import jax, cv2`, programs are counted by what JAX says that it compiles, and
repairs run beside ten counts of OpenCV's in one process. A recording of one rendered 640x480 pair.
"""

import argparse
import json
import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

FLOOR = "import jax, cv2"
MANY = 64  # repairs, shared by two workers


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: str
    target: str


def seconds(words: list[str], cores: int = 2, **environment: str) -> float:
    """Of a whole process, bound to so many cores."""
    bound = sorted(os.sched_getaffinity(0))[:cores]
    began = time.perf_counter()
    done = subprocess.run(
        words,
        capture_output=True,
        check=False,
        env={**{name: value for name, value in os.environ.items() if not name.startswith("JAX_")}, **environment},
        preexec_fn=lambda: os.sched_setaffinity(0, bound),
    )
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr.decode())
    return time.perf_counter() - began


def medians(rounds: int, **commands: Callable[[], float]) -> dict[str, float]:
    """Of each command, run in turn."""
    spent: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(rounds):
        for name, run in commands.items():
            spent[name].append(run())
    return {name: float(np.median(times)) for name, times in spent.items()}


def processes(rounds: int, folder: Path) -> Iterator[Figure]:
    """Imports and commands."""
    recording = str(recorded(folder / "recording"))
    command, kept = [sys.executable, "-m", "stereorecal"], str(folder / "kept")

    def code(text: str) -> Callable[[], float]:
        return lambda: seconds([sys.executable, "-c", text])

    def repair(cache: str) -> float:
        return seconds([*command, "recalibrate", recording, "--quiet"], XDG_CACHE_HOME=cache)

    def first() -> float:
        with tempfile.TemporaryDirectory() as empty:
            return repair(empty)

    repair(kept)
    found = medians(
        rounds,
        nothing=code("pass"),
        floor=code(FLOOR),
        lazy=code("import stereorecal"),
        loaded=code("from stereorecal import SAD, health, recalibrate, io"),
        help=lambda: seconds([*command, "--help"]),
        version=lambda: seconds([*command, "--version"]),
        strategies=lambda: seconds([*command, "strategies"], XDG_CACHE_HOME=kept),
        cached=lambda: repair(kept),
    )
    first_of_all = medians(max(1, rounds // 3), first=first)["first"]
    floor = found["floor"]
    yield Figure(FLOOR, f"{floor:.2f} s", "")
    yield Figure(f"import stereorecal / {FLOOR}", f"{found['lazy'] / floor:.2f}", "1.3")
    yield Figure("  with all that a repair needs", f"{found['loaded'] / floor:.2f}", "1.3")
    yield Figure("--help, --version", f"{found['help']:.2f} s, {found['version']:.2f} s", "0.5 s")
    yield Figure("strategies", f"{found['strategies']:.2f} s", f"{floor + 0.5:.2f} s")
    yield Figure("recalibrate, programs cached", f"{found['cached']:.2f} s", "3 s")
    yield Figure("recalibrate, nothing cached", f"{first_of_all:.2f} s", "10 s")


def recorded(folder: Path) -> Path:
    """A recording on the disk, its rig 1.2° off."""
    text = f"""
import jax, stereorecal as sr
scene = sr.synthetic.render("street", 0)
bad = sr.synthetic.decalibrate(scene.rig, jax.random.key(3), 1.2, 0.01)
sr.io.save_scene(sr.Scene(scene.name, bad, scene.pairs), {str(folder)!r})
"""
    subprocess.run([sys.executable, "-c", text], check=True)
    return folder


def compilations() -> Iterator[Figure]:
    """In a process that starts with nothing, and then is asked for something else."""
    import jax

    import stereorecal as sr

    compiled: list[str] = []

    class Heard(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if "Finished XLA compilation" in record.getMessage():
                compiled.append(record.getMessage())

    jax.config.update("jax_log_compiles", True)
    heard = logging.getLogger("jax")
    heard.handlers, heard.propagate = [Heard()], False
    heard.setLevel(logging.DEBUG)
    scene = sr.synthetic.render("street", 0, frames=3)
    start = sr.synthetic.decalibrate(scene.rig, jax.random.key(3), 2.5, 0.0225)

    def counted(pairs, **options) -> int:
        compiled.clear()
        sr.recalibrate(start, pairs, **options)
        return len(compiled)

    matcher = sr.SAD(num_disparities=96)
    yield Figure("programs compiled: first repair", f"{counted(scene.pairs[:1], matcher=matcher)}", "")
    yield Figure("  another number of frames", f"{counted(scene.pairs, matcher=matcher)}", "0")
    other = counted(scene.pairs[:1], matcher=sr.SAD(num_disparities=128))
    yield Figure("  another disparity range (at each of three scales a match)", f"{other}", "1")


def repairs(rounds: int) -> Iterator[Figure]:
    """Warm repairs beside OpenCV, and their growth."""
    import cv2
    import jax
    from speed import around, opencv_counter, scene_of, spread, timed

    import stereorecal as sr

    cores = len(os.sched_getaffinity(0))
    cv2.setNumThreads(cores)
    eight, pair = scene_of((640, 480), 8), scene_of((741, 500))
    assert eight.rig is not None
    assert pair.rig is not None
    starts = [sr.synthetic.decalibrate(eight.rig, jax.random.key(k), 2.5, 0.0225) for k in range(8)]
    one = eight.pairs[:1]
    for start in starts:
        sr.recalibrate(start, one)
    candidates = list(around(pair.rig, 10))
    small = pair.rig.resized((185, 125)), pair.pairs[0].resized((185, 125)), sr.view(pair.rig).scaled(0.25)
    counts = spread(cores, lambda: opencv_counter(*small, 32), candidates)
    turn = iter(range(10**9))

    def repair() -> object:
        return sr.recalibrate(starts[next(turn) % 8], one)

    ours, theirs = timed(rounds, repair, counts)
    yield Figure(f"a repair, {cores} thread{'s' * (cores > 1)}", f"{ours:.0f} ms", "")
    yield Figure("  / ten counts of OpenCV at quarter scale", f"{ours / theirs:.1f}", "20" if cores > 1 else "")
    together = timed(max(3, rounds // 3), lambda: sr.recalibrate(starts[next(turn) % 8], eight.pairs))[0]
    yield Figure("  eight frames / one", f"{together / ours:.1f}", "4" if cores > 1 else "")


def many() -> None:
    """Print how many warm repairs a second this process does; its share of MANY is told."""
    import jax

    import stereorecal as sr

    scene = sr.synthetic.render("street", 0)
    starts = [sr.synthetic.decalibrate(scene.rig, jax.random.key(k), 2.5, 0.0225) for k in range(8)]
    for start in starts:
        sr.recalibrate(start, scene.pairs)
    print("ready", flush=True)
    number = int(sys.stdin.readline())
    began = time.perf_counter()
    for index in range(number):
        sr.recalibrate(starts[index % 8], scene.pairs)
    print(number / (time.perf_counter() - began), flush=True)


def workers() -> Figure:
    """Two processes on a core each against one on one core."""

    def a_second(number: int) -> float:
        bound = sorted(os.sched_getaffinity(0))
        running = [
            subprocess.Popen(
                [sys.executable, __file__, "--part", "many"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                preexec_fn=lambda core=core: os.sched_setaffinity(0, [core]),  # noqa: PLW1509  no threads here
            )
            for core in bound[:number]
        ]
        for worker in running:
            assert worker.stdout is not None
            worker.stdout.readline()
        answers = []
        for worker in running:
            assert worker.stdin is not None
            worker.stdin.write(f"{MANY // number}\n")
            worker.stdin.flush()
        for worker in running:
            assert worker.stdout is not None
            answers.append(float(worker.stdout.readline()))
            worker.wait()
        return sum(answers)

    one, two = a_second(1), a_second(2)
    return Figure(f"{MANY} repairs: two workers / one, a core each", f"{two / one:.2f} ({one:.2f} a second)", "1.8")


def in_a_process(part: str, cores: int, rounds: int) -> list[Figure]:
    """What this program finds as `--part part`, bound to so many cores."""
    bound = sorted(os.sched_getaffinity(0))[:cores]
    run = subprocess.run(
        [sys.executable, __file__, "--part", part, "--rounds", str(rounds)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: os.sched_setaffinity(0, bound),
    )
    if run.returncode:
        raise SystemExit(run.stderr)
    return [Figure(**figure) for figure in json.loads(run.stdout.splitlines()[-1])]


def main() -> None:
    """Time, count, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--part", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part == "many":
        many()
        return
    if options.part:
        figures = compilations() if options.part == "compilations" else repairs(options.rounds)
        print(json.dumps([vars(figure) for figure in figures]))
        return
    with tempfile.TemporaryDirectory() as folder:
        figures = [*processes(options.rounds, Path(folder))]
    figures += in_a_process("compilations", 2, options.rounds)
    figures += [f for cores in (2, 1) for f in in_a_process("repairs", cores, options.rounds)]
    figures.append(workers())
    shown = Table(title=f"{len(os.sched_getaffinity(0))} cores", box=None)
    for head in ("figure", "measured", "target"):
        shown.add_column(head, justify="left" if head == "figure" else "right")
    for figure in figures:
        shown.add_row(figure.name, figure.value, figure.target)
    Console(width=110).print(shown)


if __name__ == "__main__":
    main()
