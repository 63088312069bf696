"""Does the node notice and correct knocks in time, what does it cost, does its memory stay? Prints a table of each.

    python plugins/ros2/tests/benchmark_node.py [--only knocks,cost,memory] [--messages 10000] [--width 640]
                                                [--axes yaw]

*knocks*: rendered drives with a knock of 0.3 degrees, pair by pair through all of the node but ROS, `auto_apply` set.
*cost*: the node at its default share, ten pairs of 640x480 a second, while another process keeps a core busy.
*memory*: the resident memory of the node and its worker, thirty pairs a second. The last two need ROS.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from rich.console import Console
from rich.table import Table
from stereorecal_ros import Kept, Settings, Watch, corrected

import stereorecal as sr
from stereorecal.online import Kind
from stereorecal.synthetic import Knock, photographs, plan_drive, render

BEFORE, AFTER = 30, 24
KNOCKS = {"pitch": (0.3, 0.0, 0.0), "yaw": (0.0, 0.3, 0.0), "roll": (0.0, 0.0, 0.3)}
TICKS = os.sysconf("SC_CLK_TCK")


def message_of(image: np.ndarray) -> SimpleNamespace:
    data = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    height, width = data.shape
    return SimpleNamespace(
        width=width, height=height, step=width, encoding="mono8", is_bigendian=0, data=data.reshape(-1)
    )


def knocked(tour: str, seed: int, degrees: tuple[float, float, float], folder: Path, width: int) -> tuple:
    """With how many pairs after the knock it is noticed, and corrected; rotation left, degrees."""
    drive = plan_drive(tour, seed, BEFORE + AFTER, knocks=(Knock(BEFORE, degrees),), weather=False)
    drive = replace(drive, rig=drive.rig.resized((width, width * 3 // 4)))
    place, settings = folder / f"{time.monotonic_ns()}.state", Settings(auto_apply=True, share=1.0)
    watch = Watch(settings, Kept(place), lambda level, text: None)
    roi = SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0)
    for side, info in enumerate(corrected(drive.rig)):
        watch.camera_info(side, SimpleNamespace(**vars(info), binning_x=0, binning_y=0, roi=roi))
    noticed = fixed = None
    while not watch._worker.runs:
        watch.poll()
        time.sleep(0.005)
    for number, pair in enumerate(photographs(drive, folder=folder)):
        after, given = number - BEFORE + 1, watch.rig
        for side, image in enumerate((pair.left, pair.right)):
            watch.image(side, number * 100_000_000, message_of(image))
        events = list(watch.poll())
        while not watch._worker.ready:
            time.sleep(0.005)
            events += watch.poll()
        events += watch.poll()
        if after > 0 and noticed is None and any(e.kind in (Kind.KNOCK, Kind.DRIFTING, Kind.REPAIRING) for e in events):
            noticed = after
        if after > 0 and fixed is None and watch.rig is not given:
            moved = np.abs(np.asarray(watch.rig.extrinsics) - np.asarray(given.extrinsics)).max()
            fixed = after if moved > np.radians(0.1) else None
    left = np.degrees(np.asarray(watch.rig.extrinsics) - drive.truth(BEFORE + AFTER - 1).extrinsics)[:3]
    watch.close()
    return noticed, fixed, left


def knocks(width: int, axes: list[str]) -> Table:
    columns = ("drive", "knock", "noticed with pair", "corrected with pair", "left: pitch, yaw, roll [deg]")
    table = Table(*columns, title=f"{width}x{width * 3 // 4}")
    with tempfile.TemporaryDirectory() as folder:
        for tour, seed in (("harbour", 2), ("harbour", 5), ("street", 1)):
            for axis in axes:
                noticed, fixed, left = knocked(tour, seed, KNOCKS[axis], Path(folder), width)
                rest = " ".join(f"{value:+.3f}" for value in left)
                table.add_row(f"{tour} {seed}", f"{axis} 0.3", str(noticed), str(fixed), rest)
    return table


def tree(process: int) -> list[int]:
    """A process and those that it started."""
    found = [process]
    for task in Path(f"/proc/{process}/task").iterdir():
        found += [one for child in (task / "children").read_text().split() for one in tree(int(child))]
    return found


def spent(process: int) -> float:
    """Seconds of processor time."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def resident(process: int) -> int:
    """Megabytes."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) // 1024


class Playing:
    """A node, and a player of rendered scenes at a rate."""

    def __init__(self, folder: str, rate: float, **parameters: object) -> None:
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from stereorecal_ros.play import Player

        os.environ.update(ROS_DOMAIN_ID="88", ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")
        rig = sr.synthetic.default_rig().resized((640, 480))
        self._pairs = [pair for seed in range(4) for pair in render("harbour", seed, rig=rig).pairs]
        rclpy.init()
        self._player, self._rate, self._sent, self.looked_at = Player(rig), rate, 0, 0
        self._player.create_subscription(DiagnosticArray, "/diagnostics", self._on_status, 10)
        self._listen = partial(rclpy.spin_once, self._player, timeout_sec=0.0)
        given = {"state_file": f"{folder}/state", **parameters}
        words = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
        self.node = subprocess.Popen([sys.executable, "-m", "stereorecal_ros", "--ros-args", *words])

    def play(self, pairs: int) -> None:
        began = time.perf_counter()
        for number in range(pairs):
            time.sleep(max(0.0, began + number / self._rate - time.perf_counter()))
            self._player.send(self._pairs[self._sent // 10 % len(self._pairs)])
            self._listen()
            self._sent += 1

    def _on_status(self, message) -> None:
        values = {value.key: value.value for value in message.status[0].values}
        self.looked_at = int(values["pairs looked at"])

    def close(self) -> None:
        self.node.terminate()
        self.node.wait()


def cost(seconds: int = 40) -> Table:
    table = Table("process", "share of one core, 640x480 at 10 Hz", title="at the default share")
    with tempfile.TemporaryDirectory() as folder, subprocess.Popen([sys.executable, "-c", "while True: pass"]) as busy:
        playing = Playing(folder, 10.0)
        try:
            playing.play(300)  # until all is compiled
            processes = tree(playing.node.pid)
            before, began, looked_at = [spent(one) for one in processes], time.perf_counter(), playing.looked_at
            playing.play(10 * seconds)
            took = time.perf_counter() - began
            for process, used in zip(processes, before, strict=True):
                name = Path(f"/proc/{process}/cmdline").read_bytes().decode().replace("\0", " ")[-60:]
                table.add_row(name, f"{100 * (spent(process) - used) / took:.1f} %")
            table.caption = f"looked at {playing.looked_at - looked_at} of {10 * seconds} pairs"
        finally:
            playing.close()
            busy.kill()
    return table


def memory(messages: int) -> Table:
    table = Table("images", "node", "resource tracker", "worker", title="640x480 at 30 Hz, megabytes")
    with tempfile.TemporaryDirectory() as folder:
        playing = Playing(folder, 30.0)
        try:
            for part in range(9):
                playing.play(messages // 16)
                sizes = sorted(((resident(one), one) for one in tree(playing.node.pid)), key=lambda pair: pair[1])
                table.add_row(str((part + 1) * (messages // 8)), *[str(size) for size, _ in sizes])
        finally:
            playing.close()
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="knocks,cost,memory")
    parser.add_argument("--messages", type=int, default=10_000)
    parser.add_argument("--width", type=int, default=320, help="of the images of the drives, pixels")
    parser.add_argument("--axes", default=",".join(KNOCKS), help="of the knocks (default: %(default)s)")
    options = parser.parse_args()
    parts = {
        "knocks": lambda: knocks(options.width, options.axes.split(",")),
        "cost": cost,
        "memory": lambda: memory(options.messages),
    }
    for name in options.only.split(","):
        # A process each: rclpy is begun once.
        if "," in options.only:
            given = ["--messages", str(options.messages), "--width", str(options.width), "--axes", options.axes]
            subprocess.run([sys.executable, __file__, "--only", name, *given], check=True)
        else:
            Console(width=140).print(parts[name]())


if __name__ == "__main__":
    main()
