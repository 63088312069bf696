"""How accurate is `recalibrate`, how often does it help, does it ever harm? Prints one table.

    python tests/benchmarks/accuracy.py [--draws N] [--degrees D] [--ends] [--only NAME,…] [--json FILE]

Scenes: rendered ones, whose truth is known, and those that STEREORECAL_DATA names. Scenes that come rectified enter
twice, as they are and with the image of each camera turned by a known random rotation. Nothing here is used by the
library: the SIFT matches of the last columns are a judge that the method never meets.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import cv2
import jax
import numpy as np
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.geometry import rectifying_rotations, rotation_from_euler, with_unit_baseline
from stereorecal.objectives import Reach
from stereorecal.recordings import Scene
from stereorecal.scoring.host import score

RENDERED = ("harbour", "coast", "street", "open-sea")
MOVING = RENDERED[:3]  # those that enter with ten frames too
REAL = {
    "boofcv_bumblebee2/garden01": 1,
    "boofcv_bumblebee2/stones01": 1,
    "boofcv_bumblebee2/sundial01": 1,
    "boofcv_bumblebee2/chair01": 1,
    "simplestereo/guitar_room": 1,
    "simplestereo/ukulele_wall": 1,
    "euroc/vicon_room_seq": 7,
    "drobotics_wide/office_050": 1,
    "kitti_odometry/suburb_seq": 1,
    "kitti2012/000000_10": 1,
    "kitti2015/000001_10": 1,
    "middlebury2014/motorcycle_quarter": 1,
}
RECTIFIED = [name for name in REAL if name.startswith(("kitti", "middlebury"))]
AXES = ("pitch", "yaw", "roll", "y", "z")
WORTH = 0.15  # pixels of row error: a start that lies so far above its candidate is worth repairing


@dataclass(frozen=True)
class Row:
    """One draw of one scene; errors in degrees and percent of the baseline."""

    scene: str
    draw: int
    reason: str
    accepted: bool
    error_before: list[float]
    error: list[float]
    interval: list[float] | None
    observed: list[bool] | None
    ratio: float
    sift_before: float
    sift_after: float
    sift_reference: float
    sift_candidate: float
    harmful: bool
    seconds: float


def scenes(only: list[str]) -> Iterator[Scene]:
    """All scenes that are at hand, or those whose name contains one of `only`."""

    def wanted(name: str) -> bool:
        return not only or any(part in name for part in only)

    for kind in RENDERED:
        if wanted(f"{kind}-0"):
            yield sr.synthetic.render(kind, 0)
        if kind in MOVING and wanted(f"{kind}-0 ten frames"):
            yield replace(sr.synthetic.render(kind, 0, frames=10), name=f"{kind}-0 ten frames")
    folder = os.environ.get("STEREORECAL_DATA")
    for name, frames in REAL.items() if folder else ():
        if wanted(name):
            yield sr.io.load_scene(Path(str(folder)) / name, limit=frames)
        if name in RECTIFIED and wanted(f"{name} turned"):
            yield turned(sr.io.load_scene(Path(str(folder)) / name, limit=frames))


def turned(scene: Scene, degrees: float = 2.0, seed: int = 0) -> Scene:
    """The scene as two cameras would have taken it that are turned by random rotations; without distortion."""
    draw, rig = np.random.default_rng(seed), scene.rig
    assert rig is not None
    turns = [rotation_from_euler(np.radians(draw.uniform(-degrees, degrees, 3))) for _ in range(2)]

    def warped(image, camera, turn):
        homography = camera.matrix @ turn @ np.linalg.inv(camera.matrix)
        size = (image.shape[1], image.shape[0])
        image = cv2.warpPerspective(image, homography, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.clip(image, 0.0, 255.0)

    pairs = tuple(
        sr.Pair(warped(p.left, rig.left, turns[0]), warped(p.right, rig.right, turns[1]), p.name) for p in scene.pairs
    )
    rotation, translation = turns[1] @ rig.rotation @ turns[0].T, turns[1] @ rig.translation
    return Scene(
        f"{scene.name} turned",
        sr.StereoRig.from_rotation(rig.left, rig.right, rotation, translation),
        pairs,
        scene.reference,
    )


def consensus(scene: Scene) -> Scene:
    """A real scene with the median end point of three repairs in place of its stored rig."""
    if scene.reference == "truth":
        return scene
    assert scene.rig is not None
    starts = [sr.synthetic.decalibrate(scene.rig, jax.random.key(k), 0.3, 0.003) for k in range(3)]
    ends = [np.asarray(sr.recalibrate(start, scene.pairs, prior="exact").candidate.extrinsics) for start in starts]
    return replace(scene, rig=scene.rig.with_extrinsics(np.median(ends, axis=0)))


def sift_rays(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Rays of mutual SIFT matches of all frames, cleaned by a robust essential matrix without any calibration's say."""
    rig, found = scene.rig, []
    assert rig is not None
    for pair in scene.pairs:
        sift = cv2.SIFT_create(8000)
        (left, left_words), (right, right_words) = (
            sift.detectAndCompute(np.round(image).astype(np.uint8), None) for image in (pair.left, pair.right)
        )
        matches = cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(left_words, right_words)
        points = [
            np.array([k[i].pt for k, i in zip((left, right), (m.queryIdx, m.trainIdx), strict=True)]) for m in matches
        ]
        if len(points) < 5:
            continue
        rays = [
            np.asarray(c.rays(np.array([p[s] for p in points])), float) for s, c in enumerate((rig.left, rig.right))
        ]
        focal = rig.left.matrix[0, 0]
        pinhole, flat = np.diag([focal, focal, 1.0]), [focal * r[:, :2] for r in rays]
        _, inliers = cv2.findEssentialMat(*flat, pinhole, method=cv2.USAC_MAGSAC, prob=0.9999, threshold=1.0)
        if inliers is not None:
            found.append([r[inliers.ravel().astype(bool)] for r in rays])
    if not found:
        return np.zeros((0, 3)), np.zeros((0, 3))
    first, second = (np.concatenate([f[side] for f in found]) for side in (0, 1))
    return first, second


def median_row_offset(rig: sr.StereoRig, rays: tuple[np.ndarray, np.ndarray]) -> float:
    """Median |Δrow| of matches under a calibration, in pixels of the left camera; NaN without matches."""
    if not len(rays[0]):
        return float("nan")
    turns = rectifying_rotations(rig.rotation, rig.translation)
    rows = [(r @ turn[1]) / (r @ turn[2]) for r, turn in zip(rays, turns, strict=True)]
    return float(np.median(np.abs(rows[0] - rows[1])) * rig.left.matrix[1, 1])


def errors(rig: sr.StereoRig, reference: sr.StereoRig) -> np.ndarray:
    """(5,) pitch, yaw, roll [degrees], y, z [percent of the baseline]."""
    difference = with_unit_baseline(rig.extrinsics) - with_unit_baseline(reference.extrinsics)
    return np.concatenate([np.degrees(difference[:3]), 100.0 * difference[4:]])


def run(scene: Scene, draws: int, degrees: float, seed: int) -> Iterator[Row]:
    """Decalibrate and repair, `draws` times."""
    rig, rays = scene.rig, sift_rays(scene)
    assert rig is not None
    fraction = 0.009 * degrees
    reach = Reach(max(3.0, 1.2 * degrees), max(0.03, 1.2 * fraction))
    for draw in range(draws):
        start = sr.synthetic.decalibrate(rig, jax.random.fold_in(jax.random.key(seed), draw), degrees, fraction)
        began = time.perf_counter()
        solution = sr.recalibrate(start, scene.pairs, reach=reach, prior="exact")
        seconds = time.perf_counter() - began
        reference = score(rig, scene.pairs, matcher=solution.matcher, view=solution.view).count
        count = (solution.score_after if solution.accepted else solution.score_before).count
        before, after = errors(start, rig), errors(solution.rig, rig)
        known = solution.uncertainty
        sift = [median_row_offset(r, rays) for r in (start, solution.rig, rig, solution.candidate)]
        harmful = solution.accepted and sift[1] > sift[0] + 0.02
        if scene.reference == "truth" and solution.accepted and known is not None:
            harmful |= bool(np.any(np.abs(after) > np.abs(before) + known.interval))
        yield Row(
            scene.name,
            draw,
            solution.reason.name,
            solution.accepted,
            before.tolist(),
            after.tolist(),
            None if known is None else known.interval.tolist(),
            None if known is None else known.observed.tolist(),
            count / reference if reference else float("nan"),
            *sift,
            harmful,
            seconds,
        )


def table(rows: list[Row], truth: bool) -> list[str]:
    """The line of one scene."""
    end = np.array([row.error for row in rows])
    centre = np.zeros(5) if truth else np.median(end, axis=0)
    away = np.abs(end - centre)
    near = np.array([r.ratio for r in rows]) >= 0.98
    within = near & (away[:, [0, 2]].max(1) <= 0.01) & (away[:, 1] <= 0.05)
    known = [row for row in rows if row.interval is not None]
    covered = [np.mean(np.abs(np.array(r.error) - centre)[:3] <= np.array(r.interval)[:3]) for r in known]
    medians = np.median(away, axis=0)
    return [
        rows[0].scene,
        f"{len(rows)}",
        f"{np.mean([r.accepted for r in rows]):.0%}",
        f"{within.mean():.0%}",
        f"{np.median([r.ratio for r in rows]):.3f}",
        *[f"{m:.4f}" for m in medians[:3]],
        *[f"{m:.2f}" for m in medians[3:]],
        *[f"{m:.4f}" for m in away[:, :3].max(0)],
        f"{np.mean(covered):.0%}" if covered else "-",
        *[f"{np.median([getattr(r, f'sift_{w}') for r in rows]):.3f}" for w in ("before", "after", "reference")],
        f"{sum(r.harmful for r in rows)}",
        f"{np.median([r.seconds for r in rows]):.1f}",
    ]


def of_use(rows: list[Row]) -> str:
    """What became of starts that were good or worth repairing, over all scenes."""
    healthy = sum(r.accepted or r.reason == "ALREADY_GOOD" for r in rows)
    worth = [r.accepted for r in rows if r.sift_before > r.sift_candidate + WORTH]
    return (
        f"{healthy} of {len(rows)} end IMPROVED or ALREADY_GOOD; of {len(worth)} whose rows lie more than {WORTH} px\n"
        f"above those of their candidate {sum(worth)} are accepted; harmful {sum(r.harmful for r in rows)}."
    )


def main() -> None:
    """Run all scenes, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--degrees", type=float, default=2.5, help="largest drift; 0.9 %% of the baseline per degree")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ends", action="store_true", help="drifts of the end points, not of stored calibrations")
    parser.add_argument("--only", default="", help="parts of names, comma separated")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    shown = Table(title=f"±{options.degrees:g}°, ±{0.9 * options.degrees:g} % of the baseline", box=None)
    heads = ["scene", "draws", "accepted", "within", "r"]
    heads += [f"median {a}" for a in AXES] + [f"worst {a}" for a in AXES[:3]]
    heads += ["covered", "SIFT before", "after", "reference", "harmful", "s"]
    for head in heads:
        shown.add_column(head, justify="left" if head == "scene" else "right")
    everything = []
    for scene in scenes([part for part in options.only.split(",") if part]):
        rows = list(run(consensus(scene) if options.ends else scene, options.draws, options.degrees, options.seed))
        everything += rows
        line = table(rows, scene.reference == "truth")
        print(" ".join(line), {r.reason for r in rows}, flush=True)
        shown.add_row(*line)
    Console(width=220).print(shown)
    print(
        "errors are against the truth of rendered scenes, else from the median end point; within: r >= 0.98, pitch and"
    )
    print("roll within 0.01°, yaw within 0.05°; covered: by the 95 % intervals of pitch, yaw and roll.")
    print(of_use(everything))
    if options.json:
        options.json.write_text(json.dumps([asdict(row) for row in everything], indent=1))


if __name__ == "__main__":
    main()
