"""How long does one wait: for an import, a command, the first repair and the next? Prints one table.

    python tests/benchmarks/start_up.py [--rounds N]

Whole processes are timed in turn with `import jax, cv2`; repairs are those of one process, or of two workers. A
recording of one rendered 640x480 pair. (How often programs are compiled: tests/scoring/test_compiled_once.py.)
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from processes import bound_to, first_cores, last_line, seconds
from tables import command_line, show, table_of

FLOOR = "import jax, cv2"
MANY = 64  # repairs, shared by two workers
RECORDED = """
import sys, jax, stereorecal as sr
scene = sr.synthetic.render("street", 0)
bad = sr.synthetic.decalibrate(scene.rig, jax.random.key(3), 1.2, 0.01)
sr.io.save_scene(sr.Scene(scene.name, bad, scene.pairs), sys.argv[1])
"""


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: str
    target: str


def medians(rounds: int, **commands: Callable[[], float]) -> dict[str, float]:
    """The median of each command, run in turn."""
    spent: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(rounds):
        for name, run in commands.items():
            spent[name].append(run())
    return {name: float(np.median(times)) for name, times in spent.items()}


def processes(rounds: int, folder: Path) -> Iterator[Figure]:
    """Imports and commands."""
    recording, kept = str(folder / "recording"), str(folder / "kept")
    command = ("-m", "stereorecal")
    subprocess.run([sys.executable, "-c", RECORDED, recording], check=True)

    def code(text: str) -> Callable[[], float]:
        return lambda: seconds("-c", text)

    def repair(cache: str) -> float:
        return seconds(*command, "recalibrate", recording, "--quiet", XDG_CACHE_HOME=cache)

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
        help=lambda: seconds(*command, "--help"),
        version=lambda: seconds(*command, "--version"),
        strategies=lambda: seconds(*command, "strategies", XDG_CACHE_HOME=kept),
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


def repairs(rounds: int) -> Iterator[Figure]:
    """Warm repairs of one frame, and of eight."""
    import jax
    from speed import scene_of, timed

    import stereorecal as sr

    eight, cores = scene_of((640, 480), 8), len(os.sched_getaffinity(0))
    start = sr.synthetic.decalibrate(eight.rig, jax.random.key(0), 2.5, 0.0225)
    ours, together = (
        timed(number, lambda pairs=pairs: sr.recalibrate(start, pairs))[0]
        for number, pairs in ((rounds, eight.pairs[:1]), (max(3, rounds // 3), eight.pairs))
    )
    yield Figure(f"a repair, {cores} thread{'s' * (cores > 1)}", f"{ours:.0f} ms", "")
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
        words = [sys.executable, __file__, "--part", "many"]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        own_cores = [bound_to([core]) for core in first_cores(number)]
        running = [subprocess.Popen(words, preexec_fn=bound, **pipes) for bound in own_cores]  # noqa: PLW1509
        for worker in running:
            worker.stdout.readline()
        for worker in running:
            worker.stdin.write(f"{MANY // number}\n")
            worker.stdin.flush()
        return sum(float(worker.communicate()[0]) for worker in running)

    one, two = a_second(1), a_second(2)
    return Figure(f"{MANY} repairs: two workers / one, a core each", f"{two / one:.2f} ({one:.2f} a second)", "1.8")


def main() -> None:
    """Time, count, print."""
    parser = command_line(__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--part", choices=("many", "repairs"), help="what processes of this one do")
    options = parser.parse_args()
    if options.part == "many":
        many()
        return
    if options.part:
        print(json.dumps([vars(figure) for figure in repairs(options.rounds)]))
        return
    with tempfile.TemporaryDirectory() as folder:
        figures = [*processes(options.rounds, Path(folder))]
    for cores in (2, 1):
        said = last_line(__file__, "--part", "repairs", "--rounds", options.rounds, cores=first_cores(cores))
        figures += [Figure(**figure) for figure in json.loads(said)]
    figures.append(workers())
    shown = table_of("figure | measured | target", title=f"{len(os.sched_getaffinity(0))} cores")
    for figure in figures:
        shown.add_row(figure.name, figure.value, figure.target)
    show(shown)


if __name__ == "__main__":
    main()
