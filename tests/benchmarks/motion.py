"""Depth from the rig's own motion: real consecutive frames, and rendered drives.

    python tests/benchmarks/motion.py [--starts N] [--size WIDTHxHEIGHT] [--only real|rendered|vehicle]

Real: `kitti_odometry/suburb_drive`, whose depth is right by lidar. The stored rig and N starts up to 2.5° and 2.25 % of
the baseline are repaired with `motion=True` from nine frames: the offset of disparity of what is written,
and of the posterior's mean, against the stored rig, rows, the distance between frames against GPS.

Vehicle: the filter over the real drive, and its processor time.

Rendered: drives, nine pairs about a baseline apart (320x240 unless --size is given), from the truth, 0.3° and 2.5°
away, and with a right shutter that is late by 0.2 of the time between two pairs.
"""

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import jax
import numpy as np
from real_scenes import DATA, present, rig_of
from tables import command_line, show, size, table_of

import stereorecal as sr
from stereorecal.estimation import points_of_view, readings
from stereorecal.online import Config, run
from stereorecal.synthetic import photographs, plan_drive

DRIVE = "kitti_odometry/suburb_drive"
FRAMES = 9  # of the real drive, and of each that is rendered
TOURS = ("street", "harbour")
EVERY = {"street": 3, "harbour": 6}  # frames from one pair to the next: about a baseline
STARTS = ((0.0, 0.0), (0.3, 0.0), (2.5, 0.0), (0.3, 0.2))  # degrees, and how late, of the time between two pairs


def offset_px(used: sr.StereoRig, true: sr.StereoRig) -> float:
    """Median over the view of the disparity that a rig reads, less what the true one does, at 30 baselines."""
    nearness = readings(used, true, points_of_view(true, 30))[1]
    return float(np.median(nearness)) * float(true.left.matrix[0, 0]) / 30.0


def real(starts: int) -> None:
    """The drive."""
    if not present(DRIVE):
        return
    scene = sr.io.load_scene(DATA / DRIVE)
    stored = rig_of(scene)
    places = np.loadtxt(DATA / DRIVE / "poses.txt").reshape(-1, 3, 4)[:, :, 3]
    gps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    table = table_of(
        "start | verdict | written, px | mean, px | rows, px | way against GPS, %: median, worst | seconds",
        title=f"suburb_drive, {FRAMES} frames: disparity against the stored rig at 30 B",
        left=2,
    )
    for seed in range(-1, starts):
        first = max(2 * seed, 0)
        rig = stored if seed < 0 else sr.synthetic.decalibrate(stored, jax.random.key(seed), 2.5, 0.0225)
        began = time.perf_counter()
        found = sr.recalibrate(rig, scene.pairs[first : first + FRAMES], motion=True)
        seconds, seen = time.perf_counter() - began, found.estimate
        way = np.array([one.metres[0] for one in seen.motions])
        apart = np.abs(100.0 * (way / gps[first : first + len(way)] - 1.0))
        table.add_row(
            "stored" if seed < 0 else f"2.5°, {seed}",
            found.reason.name,
            f"{offset_px(found.rig, stored):+.2f}",
            f"{offset_px(seen.chart.rig_at(seen.theta), stored):+.2f}",
            f"{found.row_errors.after:.3f}",
            f"{np.median(apart):.2f} {apart.max():.2f}",
            f"{seconds:.1f}",
        )
    show(table)


def on_the_vehicle() -> None:
    """The filter over the drive, from the stored rig, whose depth is right: what it puts in use, and what it knows."""
    if not present(DRIVE):
        return
    scene = sr.io.load_scene(DATA / DRIVE)
    table = table_of(
        "intrinsics | motion | condition | in use, px | estimate, px | yaw, deg | delay, frames | ms a step",
        title="suburb_drive on the vehicle: disparity at 30 B against the stored rig",
        left=3,
    )
    for config in (Config(prior="exact", motion=False), Config(motion=False), Config()):
        seconds, began = [], time.process_time()
        for stepped in run(scene.rig, scene.pairs, config):
            seconds.append(time.process_time() - began)
            began, state = time.process_time(), stepped.state
        table.add_row(
            config.prior or "default",
            "on" if config.motion else "off",
            sr.online.reading(state).condition.name,
            f"{offset_px(state.rig, scene.rig):+.2f}",
            f"{offset_px(state.chart.rig_at(state.posterior.mean), scene.rig):+.2f}",
            f"{state.offset[1]:+.3f} ± {1.96 * state.of_offset[1, 1] ** 0.5:.3f}",
            f"{state.estimate.delay:+.3f}",
            f"{1000 * np.median(seconds):.0f}",
        )
    show(table)


def depth_error_percent(used: sr.StereoRig, true: sr.StereoRig, baselines: float = 30.0) -> float:
    """The error of the depth that a rig reads, over the view, on average; positive: too far."""
    near = float(readings(used, true, points_of_view(true, baselines))[1].mean())
    return 100.0 * (1.0 / (1.0 + near) - 1.0)


def taken(tour: str, late: float, size: tuple[int, int]) -> tuple[sr.StereoRig, Sequence[sr.Pair]]:
    """The true rig and some of the pairs of a drive in clear weather, on which things move."""
    every = EVERY[tour]
    number = (FRAMES - 1) * every + 1
    plan = plan_drive(tour, 0, number, weather=False, late=((0, number, late * every),) if late else ())
    plan = replace(plan, rig=plan.rig.resized(size))
    return plan.truth(number // 2), [pair for frame, pair in enumerate(photographs(plan)) if frame % every == 0]


def rendered(size: tuple[int, int]) -> None:
    """A table of repairs."""
    table = table_of(
        "drive | from | late by | verdict | |depth error| at 30 B, %: before | written | posterior's mean: 95 % | rows "
        "| delay",
        left=4,
    )
    for tour, (degrees, late) in product(TOURS, STARTS):
        true, pairs = taken(tour, late, size)
        given = sr.synthetic.decalibrate(true, jax.random.key(0), degrees, 0.009 * degrees)
        found = sr.recalibrate(given, pairs, motion=True)
        seen, rows = found.estimate, found.row_errors
        assert seen is not None
        assert rows is not None
        _, low, high = seen.depth_error_percent(seen.theta)[30]
        delay = seen.delay
        table.add_row(
            tour,
            f"{degrees:g}°",
            f"{late:g}",
            found.reason.name,
            f"{abs(depth_error_percent(given, true)):.1f}",
            f"{abs(depth_error_percent(found.rig, true)):.2f}",
            f"{depth_error_percent(seen.chart.rig_at(seen.theta), true):+.2f}: {low:+.1f} {high:+.1f}",
            f"{rows.before:.2f} {rows.after:.2f}",
            f"{delay.seconds:+.3f}" if delay and delay.probability > 0.5 else "",
        )
    show(table)


def main() -> None:
    """All, or some."""
    parser = command_line(__doc__)
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--size", type=size, default=(320, 240), help="of the pairs that are rendered")
    parser.add_argument("--only", choices=("real", "rendered", "vehicle"))
    options = parser.parse_args()
    parts = {
        "real": lambda: real(options.starts),
        "vehicle": on_the_vehicle,
        "rendered": lambda: rendered(options.size),
    }
    for name in [options.only] if options.only else parts:
        parts[name]()


if __name__ == "__main__":
    main()
