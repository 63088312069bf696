"""Does one look tell a good calibration from a bad one? Prints a table of verdicts, and how often what is mixed up is
named.

    python tests/benchmarks/health.py [--only NAME,…] [--draws N] [--consensus FOLDER] [--mixed-up]

Rendered scenes under their true rig, real ones (STEREORECAL_DATA) under the median candidate of three repairs from 0.3°
away: as they are; with pitch or roll off by 0.05° or yaw by 0.3°, either way; with a rotation off by 1 to 2.5° and the
baseline by up to 2 %. The time of a look is told in counts: matches of the same frames at full size. --mixed-up: images
exchanged, mirrored, turned and of other scenes, and false alarms under rigs up to 5° off. --consensus keeps the
references of the real scenes.
"""

import argparse
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal import InputError
from stereorecal.geometry import StereoRig
from stereorecal.recordings import Pair, Scene
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import refuse_swapped_images, with_measured_range

RENDERED = [(kind, seed) for kind in ("harbour", "coast", "street") for seed in (1, 2, 3)]
REAL = (
    *(f"boofcv_bumblebee2/{name}" for name in ("garden01", "stones01", "sundial01", "chair01")),
    "simplestereo/guitar_room",
    "simplestereo/ukulele_wall",
    "euroc/vicon_room_seq",
    "drobotics_wide/office_050",
    "kitti_odometry/suburb_seq",
    "kitti2015/000001_10",
    "kitti2012/000000_10",
    "middlebury2014/motorcycle_quarter",
)
APART = "ukulele_wall"
SMALL = {"pitch 0.05°": (0, 0.05), "yaw 0.3°": (1, 0.3), "roll 0.05°": (2, 0.05)}


@dataclass(frozen=True)
class Row:
    """A verdict: of which scene, in which state, and what the look took in counts."""

    scene: str
    case: str
    condition: str
    verdict: str
    counts: float


def scenes(wanted: list[str]) -> Iterator[Scene]:
    folder = os.environ.get("STEREORECAL_DATA")
    for kind, seed in RENDERED:
        if not wanted or any(part in f"{kind}-{seed}" for part in wanted):
            yield sr.synthetic.render(kind, seed)
    for name in REAL if folder else ():
        if not wanted or any(part in name for part in wanted):
            yield sr.io.load_scene(Path(folder or "") / name, limit=1)


def reference(scene: Scene, kept: Path | None) -> StereoRig:
    """The truth, or the consensus of repairs."""
    assert scene.rig is not None
    if scene.reference == "truth":
        return scene.rig
    file = None if kept is None else kept / f"{scene.name.replace('/', '_')}.npy"
    if file is not None and file.exists():
        return scene.rig.with_extrinsics(np.load(file))
    starts = [sr.synthetic.decalibrate(scene.rig, jax.random.key(k), 0.3, 0.003) for k in range(3)]
    consensus = np.median(
        [sr.recalibrate(start, scene.pairs, prior="exact").candidate.extrinsics for start in starts], axis=0
    )
    if file is not None:
        np.save(file, consensus)
    return scene.rig.with_extrinsics(consensus)


def states(rig: StereoRig, draws: int) -> Iterator[tuple[str, StereoRig]]:
    """The rig, and the same off by known amounts."""
    yield "reference", rig
    for case, (axis, degrees) in SMALL.items():
        for sign in (1, -1):
            yield case, rig.with_extrinsics(rig.extrinsics + sign * np.radians(degrees) * np.eye(6)[axis])
    draw = np.random.default_rng(17)
    for _ in range(draws):
        yield "1 to 2.5°", off(rig, draw, 1.0, 2.5)


def off(rig: StereoRig, draw: np.random.Generator, least: float, most: float) -> StereoRig:
    angles = draw.uniform(-1, 1, 3)
    angles *= draw.uniform(least, most) / np.abs(angles).max()
    shifts = draw.uniform(-0.02, 0.02, 2) * rig.baseline
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians(angles), 0.0, *shifts]))


def looked(scene: Scene, case: str, rig: StereoRig) -> Row:
    """With the disparity range given, as the target of the cost is stated."""
    matcher = with_measured_range(None, pyramid(rig, scene.pairs))
    took = []
    for function in (sr.score, sr.health):
        began = time.perf_counter()
        found = function(rig, scene.pairs, matcher=matcher)
        took.append(time.perf_counter() - began)
    return Row(scene.name, case, found.condition.name, found.verdict, took[1] / took[0])


def verdicts(rows: list[Row]) -> None:
    table = Table("case", "looks", "healthy", "repair", "cannot tell", "counts (median)")
    cases = list(dict.fromkeys(row.case for row in rows))
    for apart in (False, True):
        for case in cases:
            some = [row for row in rows if row.case == case and (APART in row.scene) == apart]
            if some:
                shares = [
                    f"{np.mean([r.condition == name for r in some]):.0%}"
                    for name in ("HEALTHY", "REPAIR", "CANNOT_TELL")
                ]
                counts = f"{np.median([row.counts for row in some]):.1f}"
                table.add_row(f"{APART}: {case}" if apart else case, str(len(some)), *shares, counts)
    Console(width=120).print(table)


def named(rig: StereoRig, pair: Pair) -> str:
    try:
        refuse_swapped_images(pyramid(rig, [pair]))
    except InputError as error:
        return str(error)
    return ""


def mixed_up(given: list[tuple[Scene, StereoRig]], draws: int) -> None:
    """How often each mistake is named, and how often one is that is none."""
    said: dict[str, list[str]] = {}
    for scene, rig in given:
        pair = scene.pairs[0]
        left, right = np.asarray(pair.left), np.asarray(pair.right)
        others = [np.asarray(s.pairs[0].right) for s, _ in given if s is not scene and s.pairs[0].size == pair.size]
        cases = {
            "exchanged": (right, left),
            "both mirrored": (left[:, ::-1], right[:, ::-1]),
            "both upside down": (left[::-1, ::-1], right[::-1, ::-1]),
            "left upside down": (left[::-1, ::-1], right),
            "right upside down": (left, right[::-1, ::-1]),
            **({"of another scene": (left, others[0])} if others else {}),
        }
        for case, images in cases.items():
            said.setdefault(case, []).append(named(rig, Pair(*map(np.ascontiguousarray, images))))
        draw = np.random.default_rng(5)
        for _ in range(draws):
            said.setdefault("none (up to 5° off)", []).append(named(off(rig, draw, 0.0, 5.0), pair))
    table = Table("mistake", "asked", "named", "said")
    for case, answers in said.items():
        told = [answer for answer in answers if answer]
        table.add_row(case, str(len(answers)), str(len(told)), " | ".join(sorted({answer[:40] for answer in told})))
    Console(width=140).print(table)


def main() -> None:
    """Look, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="parts of names of scenes, comma separated")
    parser.add_argument("--draws", type=int, default=6, help="rigs far off, of each scene")
    parser.add_argument("--consensus", type=Path)
    parser.add_argument("--mixed-up", action="store_true")
    options = parser.parse_args()
    given = [
        (scene, reference(scene, options.consensus)) for scene in scenes([p for p in options.only.split(",") if p])
    ]
    if options.mixed_up:
        mixed_up(given, options.draws)
        return
    rows = []
    for scene, rig in given:
        for case, start in states(rig, options.draws):
            rows.append(looked(scene, case, start))
            print(scene.name, "|", case, "|", rows[-1].verdict, "|", f"{rows[-1].counts:.1f}", flush=True)
    verdicts(rows)


if __name__ == "__main__":
    main()
