"""How accurate is `recalibrate`, how often does it help, does it ever harm? Prints one table.

    python tests/benchmarks/accuracy.py [--draws N] [--only NAME,…]

Scenes: rendered ones, whose truth is known, and real ones (real_scenes.py). Scenes that come rectified enter
twice, as they are and with the image of each camera turned by a known random rotation. Nothing here is used by the
library: the SIFT matches of the last columns are a judge that the method never meets.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import jax
import numpy as np
from real_scenes import BUMBLEBEE, real, rig_of
from sift_rows import sift_matches, sift_rows
from tables import among, command_line, show, table_of, words

import stereorecal as sr
from stereorecal.geometry import rotation_from_euler, with_unit_baseline
from stereorecal.recordings import Scene
from stereorecal.scoring.host import score

RENDERED = ("harbour", "coast", "street", "open-sea")
MOVING = RENDERED[:3]  # those that enter with ten frames too
REAL = {
    **dict.fromkeys(BUMBLEBEE, 1),
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
DEGREES, FRACTION = 2.5, 0.0225  # of the largest drift
WORTH = 0.15  # pixels of epipolar error: a start that lies so far above its candidate is worth repairing


@dataclass(frozen=True)
class Row:
    """One draw of one scene; errors in degrees and percent of the baseline."""

    scene: str
    reason: str
    accepted: bool
    error: np.ndarray
    interval: np.ndarray | None
    ratio: float
    sift_before: float
    sift_after: float
    sift_reference: float
    sift_candidate: float
    harmful: bool
    seconds: float


def scenes(only: Sequence[str] = ()) -> Iterator[Scene]:
    """All scenes that are at hand, or those whose name contains one of `only`."""
    for kind in RENDERED:
        if among(f"{kind}-0", only):
            yield sr.synthetic.render(kind, 0)
        if kind in MOVING and among(f"{kind}-0 ten frames", only):
            yield replace(sr.synthetic.render(kind, 0, frames=10), name=f"{kind}-0 ten frames")
    for name, frames in REAL.items():
        as_it_is, also_turned = among(name, only), name in RECTIFIED and among(f"{name} turned", only)
        for scene in real({name: frames}) if as_it_is or also_turned else ():
            yield from [scene] * as_it_is + [turned(scene)] * also_turned


def as_if_turned(image: np.ndarray, camera: sr.Camera, rotation: np.ndarray) -> np.ndarray:
    """The image that the camera would have taken if it had been turned: x -> rotation x."""
    width, height = camera.size
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(float)
    where = np.asarray(camera.project(np.asarray(camera.rays(pixels)) @ rotation)).astype(np.float32)
    warped = cv2.remap(
        np.asarray(image), where[..., 0], where[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    )
    return np.clip(warped, 0.0, 255.0)


def turned_rig(rig: sr.StereoRig, left: np.ndarray, right: np.ndarray) -> sr.StereoRig:
    """The rig whose cameras are turned by these rotations."""
    rotation, translation = right @ np.asarray(rig.rotation) @ left.T, right @ np.asarray(rig.translation)
    return sr.StereoRig.from_rotation(rig.left, rig.right, rotation, translation)


def turned(scene: Scene, degrees: float = 2.0, seed: int = 0) -> Scene:
    """The scene as two cameras would have taken it that are turned by random rotations."""
    draw, rig = np.random.default_rng(seed), rig_of(scene)
    turns = [rotation_from_euler(np.radians(draw.uniform(-degrees, degrees, 3))) for _ in range(2)]
    pairs = [
        sr.Pair(as_if_turned(p.left, rig.left, turns[0]), as_if_turned(p.right, rig.right, turns[1]), p.name)
        for p in scene.pairs
    ]
    return Scene(f"{scene.name} turned", turned_rig(rig, *turns), tuple(pairs), scene.reference)


def errors(rig: sr.StereoRig, reference: sr.StereoRig) -> np.ndarray:
    """(5,) pitch, yaw, roll [degrees], y, z [percent of the baseline]."""
    difference = with_unit_baseline(rig.extrinsics) - with_unit_baseline(reference.extrinsics)
    return np.concatenate([np.degrees(difference[:3]), 100.0 * difference[4:]])


def run(scene: Scene, draws: int) -> Iterator[Row]:
    """Decalibrate and repair, `draws` times."""
    rig = rig_of(scene)
    matches = sift_matches(rig, scene.pairs)
    for draw in range(draws):
        start = sr.synthetic.decalibrate(rig, jax.random.fold_in(jax.random.key(0), draw), DEGREES, FRACTION)
        began = time.perf_counter()
        solution = sr.recalibrate(start, scene.pairs, prior="exact")
        seconds = time.perf_counter() - began
        reference = score(rig, scene.pairs, matcher=solution.matcher, view=solution.view).count
        count = (solution.score_after if solution.accepted else solution.score_before).count
        before, after = errors(start, rig), errors(solution.rig, rig)
        known = solution.uncertainty
        sift = [sift_rows(r, matches) for r in (start, solution.rig, rig, solution.candidate)]
        harmful = solution.accepted and sift[1] > sift[0] + 0.02
        if scene.reference == "truth" and solution.accepted and known is not None:
            harmful |= bool(np.any(np.abs(after) > np.abs(before) + known.interval))
        yield Row(
            scene.name,
            solution.reason.name,
            solution.accepted,
            after,
            None if known is None else known.interval,
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
    covered = [np.mean(np.abs(r.error - centre)[:3] <= r.interval[:3]) for r in known]
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
    parser = command_line(__doc__)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--only", default="", help="parts of names, comma separated")
    options = parser.parse_args()
    axes = " | ".join([*(f"median {axis}" for axis in AXES), *(f"worst {axis}" for axis in AXES[:3])])
    shown = table_of(
        f"scene | draws | accepted | within | r | {axes} | covered | SIFT before | after | reference | harmful | s",
        title=f"±{DEGREES:g}°, ±{100.0 * FRACTION:g} % of the baseline",
    )
    everything = []
    for scene in scenes(words(options.only)):
        rows = list(run(scene, options.draws))
        everything += rows
        line = table(rows, scene.reference == "truth")
        print(" ".join(line), {r.reason for r in rows}, flush=True)
        shown.add_row(*line)
    show(shown)
    print(
        "errors are against the truth of rendered scenes, else from the median end point; within: r >= 0.98,\n"
        "pitch and roll within 0.01°, yaw within 0.05°; covered: by the 95 % intervals of pitch, yaw and roll.\n"
        f"{of_use(everything)}"
    )


if __name__ == "__main__":
    main()
