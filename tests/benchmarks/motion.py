"""Depth from the rig's own motion: real consecutive frames, and simulated tracks whose truth is known.

    python tests/benchmarks/motion.py [--data FOLDER] [--starts N] [--rigs N] [--first SEED] [--windows N]
                                      [--cases NAME,…] [--seeds N] [--size WIDTHxHEIGHT]
                                      [--only real|simulated|rendered|vehicle|step|stutter]

Real: `kitti_odometry/suburb_drive`, whose depth is right by lidar. The stored rig and N starts up to 2.5° and 2.25 % of
the baseline are repaired with `motion=True` from nine frames: the offset of disparity of what is written,
and of the posterior's mean, against the stored rig, rows, the distance between frames against GPS. Then windows alone
and both halves of the drive.

Simulated: the rigs of `simulated_rigs.py` (even seeds unless --first is odd), eight windows each beside the rows of
three frames: how often the 95 % interval of depth at 30 baselines holds the truth, |depth error| of the posterior's
mean there, how many repairs would be written, and how many of them harm; with rows alone and with motion, by drift, and
for motions that tell little or are half of other things, and how late the right shutter is said to be, where it is.

Step: the filter's processor time at 640x480. Stutter: two pairs alone, and recordings that repeat pairs.

Rendered: drives, nine pairs about a baseline apart (320x240 unless --size is given), from the truth, 0.3° and 2.5°
away, and with a right shutter that is late by 0.2 of the time between two pairs.
"""

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
from motion_rendered import rendered
from motion_simulated import CASES, ROWS, simulated
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.estimation import points_of_view, readings, rig_parameters, window
from stereorecal.online import Config, run

FRAMES = 9


def offset_px(used: sr.StereoRig, true: sr.StereoRig) -> float:
    """Median over the view of the disparity that a rig reads, less what the true one does, at 30 baselines."""
    nearness = readings(used, true, points_of_view(true, 30))[1]
    return float(np.median(nearness)) * float(true.left.matrix[0, 0]) / 30.0


def real(folder: Path, starts: int, console: Console) -> None:
    """The drive."""
    scene = sr.io.load_scene(folder / "kitti_odometry" / "suburb_drive")
    places = np.loadtxt(folder / "kitti_odometry" / "suburb_drive" / "poses.txt").reshape(-1, 3, 4)[:, :, 3]
    gps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    title = f"suburb_drive, {FRAMES} frames: disparity against the stored rig at 30 B"
    table = Table(
        *("start", "written, px", "mean, px", "rows, px", "way against GPS, %: median, worst", "seconds", "verdict"),
        title=title,
        box=None,
    )
    for seed in range(-1, starts):
        rig = scene.rig if seed < 0 else sr.synthetic.decalibrate(scene.rig, jax.random.key(seed), 2.5, 0.0225)
        pairs = scene.pairs[:FRAMES] if seed < 0 else scene.pairs[2 * seed : 2 * seed + FRAMES]
        began = time.perf_counter()
        found = sr.recalibrate(rig, pairs, motion=True)
        seconds, seen = time.perf_counter() - began, found.estimate
        way = np.array([one.metres[0] for one in seen.motions])
        first = max(2 * seed, 0)
        apart = np.abs(100.0 * (way / gps[first : first + len(way)] - 1.0))
        table.add_row(
            "stored" if seed < 0 else f"2.5°, {seed}",
            f"{offset_px(found.rig, scene.rig):+.2f}",
            f"{offset_px(seen.chart.rig_at(seen.theta), scene.rig):+.2f}",
            f"{found.row_errors.after:.3f}",
            f"{np.median(apart):.2f} {apart.max():.2f}",
            f"{seconds:.1f}",
            found.reason.name,
        )
    console.print(table)
    data = sr.recalibrate(scene.rig, scene.pairs[:2], motion=True).estimate  # what one window looks like
    console.print(
        f"one window alone: {offset_px(data.chart.rig_at(data.theta), scene.rig):+.2f} px of the posterior's mean"
    )
    halves(scene, console)


def halves(scene: sr.Scene, console: Console) -> None:
    """Every window, and the halves of the drive, at the stored rig: its right principal point by which it is off, all
    else being as it is."""
    found = [sr.recalibrate(scene.rig, scene.pairs[a:b], motion=True).estimate for a, b in ((0, 9), (8, 17), (17, 26))]
    chart = rig_parameters(scene.rig)
    column, offsets = chart.names.index("right.cx"), []
    for seen in found:
        for tracks in seen.windows.tracks:
            normal = window(tracks, chart, np.zeros(chart.dim)).normal
            offsets.append(normal.b[column] / normal.a[column, column])
    half = len(offsets) // 2
    console.print(
        f"{len(offsets)} single windows: mean {np.mean(offsets):+.3f} px, scatter {np.std(offsets):.3f} px, halves "
        f"{np.mean(offsets[:half]):+.3f} {np.mean(offsets[half:]):+.3f} px; thirds of the drive, posterior's means: "
        + " ".join(f"{offset_px(seen.chart.rig_at(seen.theta), scene.rig):+.2f}" for seen in found)
    )


def on_the_vehicle(folder: Path, console: Console) -> None:
    """The filter over the drive, from the stored rig, whose depth is right: what it puts in use, and what it knows."""
    scene = sr.io.load_scene(folder / "kitti_odometry" / "suburb_drive")
    heads = (
        "intrinsics",
        "motion",
        "in use, px",
        "estimate, px",
        "yaw, deg",
        "what calibration left of yaw, deg",
        "ms a step",
        "condition",
    )
    table = Table(*heads, title="suburb_drive on the vehicle: disparity at 30 B against the stored rig", box=None)
    for config in (Config(prior="exact", motion=False), Config(motion=False), Config()):
        seconds, began = [], time.process_time()
        for stepped in run(scene.rig, scene.pairs, config):
            seconds.append(time.process_time() - began)
            began, state = time.process_time(), stepped.state
        known = state.estimate
        table.add_row(
            config.prior or "default",
            "on" if config.motion else "off",
            f"{offset_px(state.rig, scene.rig):+.2f}",
            f"{offset_px(state.rig_at(known.offset), scene.rig):+.2f}",
            f"{known.offset[1]:+.3f} ± {1.96 * known.covariance[1, 1] ** 0.5:.3f}",
            f"{known.theta[1] - known.offset[1]:+.3f}",
            f"{1000 * np.median(seconds):.0f}",
            sr.online.reading(state).condition.name,
        )
    console.print(table)


def stuttering(folder: Path, console: Console) -> None:
    """Two pairs alone, and recordings in which every third pair is there twice: the same as without."""
    scene = sr.io.load_scene(folder / "kitti_odometry" / "suburb_drive")
    started = [sr.synthetic.decalibrate(scene.rig, jax.random.key(seed), 0.3, 0.003) for seed in range(2)]
    table = Table("pairs", "start", "mean, px: 95 %", "written, px", "windows", "verdict", box=None)
    seconds = [pair.time for pair in scene.pairs]
    twice = [replace(scene.pairs[at - at // 3], time=seconds[at]) for at in range(12)]
    for name, pairs in (("two", scene.pairs[:2]), ("nine", scene.pairs[:9]), ("nine, three of them twice", twice)):
        for start, rig in zip(("stored", ".3°, 0", ".3°, 1"), (scene.rig, *started), strict=True):
            found = sr.recalibrate(rig, pairs)
            seen = found.estimate
            ends = (100.0 / (100.0 + end) - 1.0 for end in seen.depth_error_percent(seen.theta)[30][:0:-1])
            low, high = (end * float(rig.left.matrix[0, 0]) / 30.0 for end in ends)
            means = f"{offset_px(seen.chart.rig_at(seen.theta), scene.rig):+.2f}: {low:+.2f} {high:+.2f}"
            written = f"{offset_px(found.rig, scene.rig):+.2f}"
            table.add_row(name, start, means, written, f"{len(seen.windows.tracks)}", found.reason.name)
    console.print(table)


def step_of_the_filter(console: Console) -> None:
    """Processor time of a step at 640x480, on a street that things drive on."""
    rig = sr.synthetic.default_rig()
    drive = sr.synthetic.plan_drive("street", 0, 60, weather=False)
    drive = replace(drive, rig=rig, extrinsics=np.tile(np.asarray(rig.extrinsics), (len(drive), 1)))
    pairs = list(sr.synthetic.photographs(drive))
    for motion in (False, True):
        seconds, began = [], time.process_time()
        for _ in run(rig, pairs, Config(motion=motion)):
            seconds.append(time.process_time() - began)
            began = time.process_time()
        middle, late = 1000.0 * np.quantile(seconds[10:], (0.5, 0.9))
        console.print(
            f"640x480, motion {'on' if motion else 'off'}: {middle:.0f} ms a step, 90th percentile {late:.0f}"
        )


def main() -> None:
    """All, or some."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("STEREORECAL_DATA", "../shared/data")))
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--cases", default=",".join((ROWS, *CASES)), help="of simulated rigs")
    parser.add_argument("--seeds", type=int, default=1, help="drives of each kind that are rendered")
    parser.add_argument("--size", default="320x240", help="of the pairs that are rendered")
    parser.add_argument("--windows", type=int, default=8, help="of each simulated rig")
    parser.add_argument("--only", choices=("real", "simulated", "rendered", "vehicle", "step", "stutter"))
    options = parser.parse_args()
    console = Console(width=170)
    if options.only in (None, "real"):
        real(options.data, options.starts, console)
    if options.only in (None, "vehicle"):
        on_the_vehicle(options.data, console)
    if options.only in (None, "step"):
        step_of_the_filter(console)
    if options.only in (None, "stutter"):
        stuttering(options.data, console)
    if options.only in (None, "simulated"):
        simulated(options.rigs, options.first, options.windows, options.cases.split(","), console)
    if options.only in (None, "rendered"):
        width, height = map(int, options.size.split("x"))
        rendered(range(options.first, options.first + options.seeds), (width, height), console)


if __name__ == "__main__":
    main()
