"""Is a good rig ever replaced by a bad one, where five parameters cannot explain the images? Prints two tables.

    python tests/benchmarks/misfit.py [--draws N] [--frames N] [--only NAME,…] [--unseen | --new | --common]
        [--part I/N] [--json FILE] [--record FOLDER]
    python tests/benchmarks/misfit.py --show FILE …
    python tests/benchmarks/misfit.py --turning

Rendered and real scenes are spoiled in many ways, half of which the model explains (noise, blur, exposure, JPEG from
20 on, glints, rain, fixed dirt) and half of which it does not, and repaired from the true rig, from 0.3° and from 2.5°
away; with several frames, what moves does so differently in each, but for --common: five frames with one cause. Judges:
rows by correspondences that were found on the CLEAN images under the true rig and over the view at 5, 10 and 30
baselines, depth at 30 by the true rig (not of real scenes: what stands there for the true rig is the consensus of
repairs of the clean images). Harmful: accepted, and a row error grown by more than 0.05 px (in brackets: 0.02), or the
median |error of depth| by more than a percentage point. Missed: in need, rows worse than 0.2 px, and not accepted.
Kinds that parameters of the model explain, so that no image can tell them from a rig, are printed by themselves and not
counted; so are late images, which show the rig from another pose.

With --turning: what no single frame can tell, a late right image on a rig that only turns, which is another pose of the
right camera, exactly.
"""

import argparse
import json
import os
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import jax
import numpy as np
from accuracy import consensus
from recorded import NEED, ROWS_CHANGED, ByTrueRig, Case
from rich.console import Console
from rich.table import Table
from spoiled_images import (
    COMMON,
    COMMON_OF_THE_MODEL,
    EXPLAINED,
    MOVING,
    NEW,
    OF_THE_MODEL,
    UNEXPLAINED,
    UNSEEN,
    Spoil,
)

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.recordings import Scene
from stereorecal.scoring import host, pyramid
from stereorecal.scoring.host import with_measured_range

RENDERED = [(kind, seed) for kind in ("harbour", "coast", "street") for seed in (1, 2)]
REAL = (
    "boofcv_bumblebee2/garden01",
    "euroc/vicon_room_seq",
    "kitti_odometry/suburb_seq",
    "middlebury2014/motorcycle_quarter",
)
FRAMES_IN_COMMON = 5
STARTS = {"true": (0.0, 0.0), "0.3°": (0.3, 0.003), "2.5°": (2.5, 0.0225)}


SEEN = {**EXPLAINED, **UNEXPLAINED}
LATE = "late right"  # of a rig that moves forward: the right image of the next frame
TURNED = (0.1, 0.3, 1.0)  # degrees to the side, between the exposures of a rig that only turns


@dataclass(frozen=True)
class Row:
    """One repair."""

    scene: str
    case: str
    explained: bool
    start: str
    frames: int
    reason: str
    accepted: bool
    harmful: bool
    changed: bool
    depth_worse: float
    rows_before: float
    rows_after: float
    view_before: float
    view_after: float
    seconds: float

    @property
    def missed(self) -> bool:
        return not self.accepted and max(self.rows_before, np.nan_to_num(self.view_before)) > NEED


def scenes(frames: int) -> Iterator[tuple[Scene, Scene | None]]:
    """Clean scenes, and with them the same with a late right image where the rig moves."""
    for kind, seed in RENDERED:
        whole = sr.synthetic.render(kind, seed, frames=frames + 1)
        late = [sr.Pair(a.left, b.right, a.name) for a, b in zip(whole.pairs, whole.pairs[1:], strict=False)]
        yield replace(whole, pairs=whole.pairs[:frames]), replace(whole, pairs=tuple(late))
    if folder := os.environ.get("STEREORECAL_DATA"):
        for name in REAL:
            scene = sr.io.load_scene(Path(folder) / name, limit=frames)
            yield scene, None


def turning() -> None:
    """Repairs of true rigs that turned between the exposures."""
    table = Table("turned", "repairs", "accepted", "yaw moved by, median", box=None)
    rig = sr.synthetic.default_rig()
    for degrees in TURNED:
        seen = rig.with_extrinsics(rig.extrinsics + np.radians([0, degrees, 0, 0, 0, 0]))
        found = [sr.recalibrate(rig, sr.synthetic.render(kind, seed, rig=seen).pairs) for kind, seed in RENDERED]
        moved = [float(np.degrees(s.rig.extrinsics[1] - rig.extrinsics[1])) for s in found]
        table.add_row(f"{degrees}°", f"{len(found)}", f"{sum(s.accepted for s in found)}", f"{np.median(moved):.3f}°")
    Console().print(table)


def judged(
    scene: Scene, given: Scene, case: str, explained: bool, judge: ByTrueRig, options: argparse.Namespace
) -> Iterator[Row]:
    """Repair a spoiled scene from every start."""
    rig = judge.true
    for name, (degrees, fraction) in STARTS.items():
        for draw in range(options.draws if degrees else 1):
            key = jax.random.fold_in(jax.random.key(zlib.crc32(f"{scene.name} {case}".encode())), draw)
            start = sr.synthetic.decalibrate(rig, key, degrees, fraction) if degrees else rig
            solution = sr.recalibrate(start, given.pairs)
            before, after = judge(start), judge(solution.rig)
            if not case.startswith(OF_THE_MODEL) and case not in (*COMMON_OF_THE_MODEL, LATE):
                kind = "misfit-explained" if explained else options.kind
                Case.of(kind, f"{scene.name} | {case} | {name} {draw}", solution, judge).record(options.record)
            yield Row(
                scene.name,
                case,
                explained,
                name,
                len(given.pairs),
                solution.reason.name,
                solution.accepted,
                after.worse_than(before),
                after.worse_than(before, ROWS_CHANGED),
                float(np.nan_to_num(after.depth - before.depth)),
                *(both[0] for both in (before.rows, after.rows)),
                *(both[-1] if judge.known else float("nan") for both in (before.rows, after.rows)),
                solution.seconds,
            )


def spoiled(scene: Scene, spoil: Spoil, case: str, *, common: bool = False) -> Scene:
    pairs = []
    for index, pair in enumerate(scene.pairs):
        draw = np.random.default_rng([zlib.crc32(case.encode()), 0 if common else index])
        images = spoil(np.asarray(pair.left, float), np.asarray(pair.right, float), draw)
        if (
            index and case.startswith(MOVING) and not common
        ):  # frames whose motions differ: the other way round, or at rest
            clean = [np.asarray(image, float) for image in (pair.left, pair.right)]
            images = (images, spoil(clean[1], clean[0], draw)[::-1], clean)[int(draw.integers(3))]
        left, right = (np.clip(np.round(image), 0, 255).astype(np.float32) for image in images)
        pairs.append(sr.Pair(left, right, pair.name))
    return replace(scene, pairs=tuple(pairs))


def main() -> None:
    """Spoil, repair, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=2, help="starts at 0.3° and at 2.5°, each")
    parser.add_argument("--frames", type=int, default=1)
    parser.add_argument("--only", default="", help="parts of names of scenes or cases, comma separated")
    parser.add_argument("--unseen", action="store_true", help="the kinds that no rule was chosen on")
    parser.add_argument("--new", action="store_true", help="ten more kinds that no rule was chosen on")
    parser.add_argument("--common", action="store_true", help="five frames of which a part has one cause")
    parser.add_argument(
        "--show", type=Path, nargs="+", metavar="FILE", help="the tables of such files, and nothing else"
    )
    parser.add_argument("--turning", action="store_true", help="late on a rig that only turns, and nothing else")
    parser.add_argument("--part", default="0/1", help="every N-th case from the I-th on, for several processes")
    parser.add_argument("--json", type=Path, help="a line for each repair, appended")
    parser.add_argument("--record", type=Path, help="a folder for replay.py")
    options = parser.parse_args()
    chosen = [kind for kind in ("common", "new", "unseen") if getattr(options, kind)]
    options.kind = "-".join(["misfit", *chosen, *(["frames"] if options.frames > 1 else [])])
    if options.turning:
        turning()
        return
    if options.show:
        show([Row(**json.loads(line)) for path in options.show for line in path.read_text().splitlines()])
        return
    frames = FRAMES_IN_COMMON if options.common else options.frames
    wanted = [part for part in options.only.split(",") if part]
    part, parts = map(int, options.part.split("/"))
    rows, number = [], 0
    for clean, late in scenes(frames):
        scene = judge = None
        if options.common and len(clean.pairs) < frames:
            continue
        seen = not (options.new or options.unseen or options.common)
        kinds = COMMON if options.common else NEW if options.new else UNSEEN if options.unseen else SEEN
        cases = [*kinds, *([LATE] if late is not None and seen else [])]
        for case in cases:
            if wanted and not any(w in f"{clean.name} {case}" for w in wanted):
                continue
            number += 1
            if number % parts != part:
                continue
            if scene is None or judge is None:
                scene = consensus(clean)
                assert scene.rig is not None
                images = pyramid(scene.rig, scene.pairs)
                unit, matcher = with_unit_baseline(scene.rig.extrinsics), with_measured_range(None, images)
                rendered = scene.name.startswith(tuple(kind for kind, _ in RENDERED))
                judge = ByTrueRig(scene.rig, host.correspondences(images.at(1.0), unit, matcher), rendered)
            given = (
                spoiled(scene, kinds[case], case, common=options.common)
                if case != LATE
                else replace(late, rig=scene.rig)
            )
            for row in judged(scene, given, case, case in EXPLAINED, judge, options):
                rows.append(row)
                if options.json:
                    with options.json.open("a") as file:
                        file.write(json.dumps(vars(row)) + "\n")
                print(
                    row.scene,
                    "|",
                    row.case,
                    "|",
                    row.start,
                    "|",
                    row.reason,
                    "| harmful" if row.harmful else "",
                    flush=True,
                )
    show(rows)


def show(rows: list[Row]) -> None:
    table = Table(box=None)
    heads = (
        "case",
        "repairs",
        "accepted: true",
        "0.3°",
        "2.5°",
        "harmful",
        "missed",
        "depth worse, at most",
        "reasons",
    )
    for head in heads:
        table.add_column(head, justify="left" if head in ("case", "reasons") else "right")
    groups = {case: [r for r in rows if r.case == case] for case in dict.fromkeys(r.case for r in rows)}
    own = [r for r in rows if r.case.startswith(OF_THE_MODEL) or r.case in COMMON_OF_THE_MODEL]
    groups |= {
        "all explained": [r for r in rows if r.explained],
        "all unexplained": [r for r in rows if not r.explained and r not in own and r.case != LATE],
        "of the model, not counted": own,
    }
    for case, some in groups.items():
        if not some:
            continue
        of = [[r.accepted for r in some if r.start == start] for start in STARTS]
        harmful, changed = (sum(getattr(r, name) for r in some) for name in ("harmful", "changed"))
        table.add_row(
            case,
            f"{len(some)}",
            *(f"{sum(a)}/{len(a)}" for a in of),
            f"{harmful} ({changed})",
            f"{sum(r.missed for r in some)}",
            f"{max(r.depth_worse for r in some):+.1f} %",
            " ".join(sorted({r.reason for r in some})),
        )
    Console(width=200).print(table)


if __name__ == "__main__":
    main()
