"""Depth from the rig's own motion: real consecutive frames, and simulated tracks whose truth is known.

    python tests/benchmarks/motion.py [--data FOLDER] [--starts N] [--rigs N] [--first SEED] [--only real|simulated]

Real: `kitti_odometry/suburb_drive`, whose depth is right by lidar. The stored rig and N starts up to 2.5° and 2.25 % of
the baseline are repaired with `motion=True` from nine frames: the offset of disparity of what is written,
and of the posterior's mean, against the stored rig, rows, the distance between frames against GPS. Then windows alone
and both halves of the drive.

Simulated: the rigs of `simulated_rigs.py` (even seeds unless --first is odd), two windows each: how often the 95 %
interval of depth at 30 baselines holds the truth, and the median |depth error| of the posterior's mean, with rows alone
and with motion, by drift; and for motions that tell little or are half of other things.
"""

import argparse
import os
import time
from pathlib import Path

import jax
import numpy as np
import simulated_rigs
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.estimation import NO_WINDOWS, Estimate, Windows, as_prior, estimate, readings, rig_parameters
from stereorecal.estimation._consequences import points_of_view
from stereorecal.estimation._motion_window import window
from stereorecal.geometry import rotation_from_vector
from stereorecal.scoring import Tracks

FRAMES = 9
DRIFTS = (("none", 0.0), ("all", 0.3), ("all", 2.5))
MOVES = {
    "ahead": {},
    "half of the near points move along": {"along": 0.5},
    "sideways": {"move": (-0.8, 0.0, 0.0)},
    "turning only": {"move": (0.0, 0.0, 0.0), "turn": (0.0, 0.03, 0.0)},
    "at rest": {"move": (0.0, 0.0, 0.0), "turn": (0.0, 0.0, 0.0)},
    "a wall": {"wall": True},
}


# Real.


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
            f"{offset_px(seen.mean_rig, scene.rig):+.2f}",
            f"{found.row_errors.after:.3f}",
            f"{np.median(apart):.2f} {apart.max():.2f}",
            f"{seconds:.1f}",
            found.reason.name,
        )
    console.print(table)
    data = sr.recalibrate(scene.rig, scene.pairs[:2], motion=True).estimate  # what one window looks like
    console.print(f"one window alone: {offset_px(data.mean_rig, scene.rig):+.2f} px of the posterior's mean")
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
        + " ".join(f"{offset_px(seen.mean_rig, scene.rig):+.2f}" for seen in found)
    )


# Simulated.


def tracks_of(
    rig: simulated_rigs.Simulated,
    draw: int,
    move=(0.02, 0.01, -0.8),
    turn=(0.002, -0.004, 0.001),
    along: float = 0.0,
    wall: bool = False,
) -> Tracks:
    """One window: the scene's points, with errors that neighbours have in common, and a tenth of wrong ones."""
    rng = np.random.default_rng([rig.seed, 77, draw])
    size, baseline = np.array(rig.calibrated.left.size, float), float(np.linalg.norm(rig.translation))
    left = rng.uniform(0.0, 1.0, (1600, 2)) * (size - 1.0)
    rays = rig.left.rays(left)
    near = simulated_rigs._nearness(rays, rng) if not wall else np.full(len(rays), 1.0 / 12.0)
    points = rays / near[:, None] * baseline
    later = points @ np.asarray(rotation_from_vector(np.array(turn)), float).T + baseline * np.array(move)
    stays = (near > np.nanmedian(near)) & (rng.random(len(near)) < along)
    later[stays] = points[stays] + 0.02 * baseline * rng.normal(size=3)
    shown = [rig.left.pixels(some) for some in (points, later)]
    partners = [rig.right.pixels(some @ rig.rotation.T + rig.translation) for some in (points, later)]
    cells = tuple((left / size * [14, 9]).astype(int).T)

    def shared() -> np.ndarray:
        return rng.normal(0.0, 0.04, (14, 9, 2))[cells]

    tracking = rng.normal(0.0, 0.08, left.shape) + shared()
    shown[1] = shown[1] + tracking
    disparity = shared() + rng.normal(0.0, 0.06, left.shape)  # the same at both times
    for index in (0, 1):
        partners[index] = partners[index] + disparity + rng.normal(0.0, 0.08, left.shape) + index * tracking
    wrong = rng.random(len(left)) < 0.1
    shown[1][wrong] += rng.uniform(-3.0, 3.0, (wrong.sum(), 2))
    good = np.isfinite(np.column_stack([rays, *shown, *partners])).all(axis=1)
    return Tracks(np.stack([left, shown[1]]), np.stack(partners)).of(good)


def held(rig: simulated_rigs.Simulated, seen: Estimate) -> tuple[bool, float]:
    """Whether the interval of depth at 30 baselines of the posterior's mean holds the truth; and |error| in percent."""
    (error,) = rig.depth_error_percent(seen.mean_rig, [30.0])
    _, low, high = seen.depth_error_percent(seen.theta)[30]
    return low <= error <= high, abs(error)


def simulated(rigs: int, first: int, console: Console) -> None:
    """Two windows for each rig."""
    table = Table(
        "motion", "drift", "rigs", "held: rows, with motion", "|depth error| at 30 B, %: median, 95th", box=None
    )
    for name, options in MOVES.items():
        for kind, degrees in DRIFTS if name == "ahead" else DRIFTS[1:2]:
            ends: list[list[tuple[bool, float]]] = [[], []]
            for seed in range(first, first + 2 * rigs, 2):
                rig = simulated_rigs.simulated(seed, kind, degrees)
                prior, rows = as_prior(None, rig_parameters(rig.calibrated)), rig.correspondences(3)
                windows = Windows(tuple(tracks_of(rig, draw, **options) for draw in range(2)))
                for found, told in zip(ends, (NO_WINDOWS, windows), strict=True):
                    found.append(held(rig, estimate(rows, rig.calibrated, prior, windows=told)))
            holds = [100.0 * np.mean([one for one, _ in found]) for found in ends]
            said = [np.quantile([error for _, error in found], (0.5, 0.95), method="higher") for found in ends]
            table.add_row(
                name,
                f"{kind} {degrees:g}°",
                f"{rigs}",
                " ".join(f"{share:.0f}" for share in holds),
                " | ".join(f"{middle:.2f} {high:.2f}" for middle, high in said),
            )
    console.print(table)


def main() -> None:
    """Both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("STEREORECAL_DATA", "../shared/data")))
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", choices=("real", "simulated"))
    options = parser.parse_args()
    console = Console(width=170)
    if options.only != "simulated":
        real(options.data, options.starts, console)
    if options.only != "real":
        simulated(options.rigs, options.first, console)


if __name__ == "__main__":
    main()
