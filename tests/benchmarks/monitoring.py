"""What does watching a rig cost, does it last, and does it see knocks in real sequences? Prints a table of each.

    python tests/benchmarks/monitoring.py [--only cost,memory,kill,real]

*cost*: steps at ten pairs of 640x480 a second, in a process bound to one core while another process keeps the other
core busy. *memory*: the resident memory of a process over many steps. *kill*: `monitor` is killed at moments drawn at
random, and goes on from its state. *real*: the sequences of STEREORECAL_DATA, forth as they are, then back and forth
as if the right camera had been turned by 0.3 degrees of pitch or roll, or 1 degree of yaw.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from accuracy import as_if_turned, turned_rig
from drives import ALARMS, effects, harmful
from processes import first_cores, last_line, memory_mb
from real_scenes import real, rig_of
from rich.table import Table
from tables import command_line, show, table_of, words

import stereorecal as sr
from stereorecal.io import save_scene
from stereorecal.recordings import Pair, Scene
from stereorecal.synthetic import photographs, plan_drive, render

RATE = 10.0  # pairs a second
SEQUENCES = ("kitti_odometry/suburb_seq", "euroc/vicon_room_seq")
KNOCKS = {"pitch": (0.3, 0.0, 0.0), "yaw": (0.0, 1.0, 0.0), "roll": (0.0, 0.0, 0.3)}  # degrees


def steps_at_rate(every: int, seconds: float) -> None:
    """Run as a process of its own: prints its share of the core, and how long steps took."""
    cv2.setNumThreads(1)
    rig = sr.synthetic.default_rig().resized((640, 480))
    pairs = [pair for seed in range(4) for pair in render("harbour", seed, rig=rig).pairs]
    state = sr.online.init(rig, sr.online.Config(every=every))
    for pair in pairs * 2:
        state, _ = sr.online.step(state, pair)
    took, began, spent = [], time.perf_counter(), time.process_time()
    for number in range(int(seconds * RATE)):
        time.sleep(max(0.0, began + number / RATE - time.perf_counter()))
        at = time.perf_counter()
        state, _ = sr.online.step(state, pairs[number // 10 % len(pairs)])
        took.append(time.perf_counter() - at)
    share = (time.process_time() - spent) / (time.perf_counter() - began)
    print(json.dumps([share, *(1e3 * np.quantile(took, (0.5, 0.99))).tolist()]))


def cost() -> Table:
    heads = "looks at | share of one core (target 25 %) | a step, median / 99th percentile"
    table = table_of(heads, title="640x480, 10 Hz")
    mine, other = first_cores(2)
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as busy:
        os.sched_setaffinity(busy.pid, {other})
        try:
            for every in (1, 2, 3):
                share, median, most = json.loads(last_line(__file__, "--part", every, cores=[mine]))
                table.add_row(f"1 pair in {every}", f"{100 * share:.0f} %", f"{median:.0f} / {most:.0f} ms")
        finally:
            busy.kill()
    return table


def memory(steps: int = 10_000) -> Table:
    table = table_of("steps | resident", title="320x240, one drive again and again")
    drive = plan_drive("harbour", 2, 40)
    pairs, state = list(photographs(drive)), sr.online.init(drive.rig)
    for number in range(1, steps + 1):
        state, _ = sr.online.step(state, pairs[number % len(pairs)])
        if number in (100, 1000) or number % 2500 == 0:
            table.add_row(str(number), f"{memory_mb()} MB")
    return table


def kill(times: int = 12) -> Table:
    """Each start goes on from the state that was left; what it says first tells at which pair."""
    table = table_of("killed | went on at the pair after the last one it had told of | lost more than that step")
    kept = lost = 0
    with tempfile.TemporaryDirectory() as folder:
        scene, place = Path(folder) / "scene", Path(folder)
        rig = sr.synthetic.default_rig().resized((320, 240))
        save_scene(render("harbour", 0, frames=40, rig=rig), scene)
        command = [sys.executable, "-m", "stereorecal", "monitor", str(scene), "--state", str(place / "state")]
        last, draw = None, random.Random(0)
        for number in range(times):
            said = place / f"{number}.jsonl"
            with subprocess.Popen([*command, "--json", str(said), "--quiet"], stderr=subprocess.DEVNULL) as process:
                while process.poll() is None and not (said.exists() and said.stat().st_size):
                    time.sleep(0.01)
                time.sleep(draw.uniform(0.0, 1.0))
                process.send_signal(signal.SIGKILL)
            frames = [json.loads(line)["frame"] for line in said.read_text().splitlines() if line.endswith("}")]
            if last is not None and frames:
                # What is saved is at most one step ahead of what was told.
                kept += frames[0] in (last + 1, last + 2)
                lost += frames[0] <= last
            last = frames[-1] if frames else last
    table.add_row(str(times), f"{kept} of {times - 1}", str(lost))
    return table


def knocked(scene: Scene, degrees: tuple[float, float, float], sign: float) -> tuple[int | None, int, int, str]:
    """Pairs until it was noticed, switches, harmful ones, and the errors of rows [px] and depth [%] at the end. True is
    a repair of the whole sequence before the knock, lenses and all."""
    turn, forth, rig = cv2.Rodrigues(sign * np.radians(degrees))[0], list(scene.pairs), rig_of(scene)
    truth = sr.recalibrate(rig, forth).rig
    there = [Pair(pair.left, as_if_turned(pair.right, rig.right, turn), pair.name) for pair in forth]
    pairs = [*forth, *there[::-1], *there]
    state = sr.online.init(rig)
    noticed, switches, worse, before, true = None, 0, 0, state.rig, truth
    for number, pair in enumerate(pairs):
        state, events = sr.online.step(state, pair, float("inf"))
        after = number - len(forth) + 1
        if after > 0 and noticed is None and any(event.kind in ALARMS for event in events):
            noticed = after
        true = turned_rig(truth, np.eye(3), turn) if after > 0 else truth
        if np.any(state.rig.extrinsics != before.extrinsics):
            switches += 1
            worse += harmful(state, before, true)
        before = state.rig
    return noticed, switches, worse, "{:.3f} px, {:.1f} %".format(*effects(before, true, state))


def real_sequences() -> Table:
    table = table_of(
        "sequence | knock | noticed with pair | switches | harmful | left: rows, depth at 30 B", title="real", left=2
    )
    for scene in real(SEQUENCES, None):
        for axis, degrees in KNOCKS.items():
            for sign in (1.0, -1.0):
                noticed, switches, worse, left = knocked(scene, degrees, sign)
                said = "never" if noticed is None else str(noticed)
                table.add_row(scene.name, f"{axis} {sign * max(degrees):+.1f}", said, f"{switches}", f"{worse}", left)
    return table


def main() -> None:
    """Print a table for each part."""
    parser = command_line(__doc__)
    parser.add_argument("--only", default="cost,memory,kill,real")
    parser.add_argument("--part", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part:
        steps_at_rate(options.part, 20.0)
        return
    parts = {"cost": cost, "memory": memory, "kill": kill, "real": real_sequences}
    for name in words(options.only):
        show(parts[name]())


if __name__ == "__main__":
    main()
