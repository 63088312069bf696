"""Is a good rig ever replaced by a bad one, where five parameters cannot explain the images? Prints two tables.

    python tests/benchmarks/misfit.py [--draws N] [--only NAME,…] [--unseen | --new] [--frames N] [--record FOLDER]
    python tests/benchmarks/misfit.py --turning

Rendered and real scenes are spoiled in many ways, half of which the model explains (noise, blur, exposure, JPEG from 20
on, glints, rain, fixed dirt, vignetting) and half of which it does not, and repaired from the true rig, from 0.3° and
from 2.5° away. Judges: rows by correspondences that were found on the CLEAN images under the true rig and over the view
at 5, 10 and 30 baselines, depth at 30 by the true rig (not of real scenes: what stands there for the true rig is the
consensus of repairs of the clean images). Harmful: accepted, and an epipolar error grown by more than 0.05 px (in
brackets: 0.02), or the median |error of depth| by more than a percentage point. Missed: in need, rows worse than 0.2
px, and not accepted. Kinds that parameters of the model explain, so that no image can tell them from a rig, are printed
by themselves and not counted; so are late images, which show the rig from another pose.

With --frames: several frames of a rendered rig, each of another place and spoiled by another draw.

With --turning: what no single frame can tell, a late right image on a rig that only turns, which is another pose of the
right camera, exactly.
"""

import argparse
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import jax
import numpy as np
from accuracy import MOVING
from real_scenes import real, rig_of
from recorded import ROWS_CHANGED, ByTrueRig, Case
from spoiled_images import EXPLAINED, KINDS, OF_THE_MODEL, spoiled
from tables import among, command_line, show, table_of, words

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.recordings import Scene
from stereorecal.scoring import host, pyramid
from stereorecal.scoring.host import with_measured_range

RENDERED = [(kind, seed) for kind in MOVING for seed in (1, 2)]
REAL = (
    "boofcv_bumblebee2/garden01",
    "euroc/vicon_room_seq",
    "kitti_odometry/suburb_seq",
    "middlebury2014/motorcycle_quarter",
)
STARTS = {"true": (0.0, 0.0), "0.3°": (0.3, 0.003), "2.5°": (2.5, 0.0225)}
LATE = "late right"  # of a rig that moves forward: the right image of the next frame
TURNED = (0.1, 0.3, 1.0)  # degrees to the side, between the exposures of a rig that only turns


@dataclass(frozen=True)
class Row:
    """One repair."""

    scene: str
    case: str
    explained: bool
    start: str
    reason: str
    accepted: bool
    harmful: bool
    changed: bool
    missed: bool
    depth_worse: float


def scenes(frames: int) -> Iterator[tuple[Scene, Scene | None]]:
    """Clean scenes, and with them the same with a late right image where the rig moves; or rendered ones of several
    frames, each of another place."""
    for number, (kind, seed) in enumerate(RENDERED if frames > 1 else ()):
        others = [sr.synthetic.render(MOVING[(number + i) % len(MOVING)], seed + 10 * i) for i in range(1, frames)]
        first = sr.synthetic.render(kind, seed)
        yield replace(first, pairs=(*first.pairs, *(one.pairs[0] for one in others))), None
    if frames > 1:
        return
    for kind, seed in RENDERED:
        whole = sr.synthetic.render(kind, seed, frames=2)
        first, second = whole.pairs
        late = sr.Pair(first.left, second.right, first.name)
        yield replace(whole, pairs=(first,)), replace(whole, pairs=(late,))
    yield from ((scene, None) for scene in real(REAL))


def consensus(scene: Scene) -> Scene:
    """A real scene with the median end point of three repairs in place of its stored rig."""
    if scene.reference == "truth":
        return scene
    rig = rig_of(scene)
    starts = [sr.synthetic.decalibrate(rig, jax.random.key(k), 0.3, 0.003) for k in range(3)]
    ends = [np.asarray(sr.recalibrate(start, scene.pairs, prior="exact").candidate.extrinsics) for start in starts]
    return replace(scene, rig=rig.with_extrinsics(np.median(ends, axis=0)))


def turning() -> None:
    """Repairs of true rigs that turned between the exposures."""
    table = table_of("turned | repairs | accepted | yaw moved by, median")
    rig = sr.synthetic.default_rig()
    for degrees in TURNED:
        seen = rig.with_extrinsics(rig.extrinsics + np.radians([0, degrees, 0, 0, 0, 0]))
        found = [sr.recalibrate(rig, sr.synthetic.render(kind, seed, rig=seen).pairs) for kind, seed in RENDERED]
        moved = [float(np.degrees(s.rig.extrinsics[1] - rig.extrinsics[1])) for s in found]
        table.add_row(f"{degrees}°", f"{len(found)}", f"{sum(s.accepted for s in found)}", f"{np.median(moved):.3f}°")
    show(table)


def judge_of(scene: Scene) -> ByTrueRig:
    """The judge of a scene, by its clean images."""
    rig, images = rig_of(scene), pyramid(rig_of(scene), scene.pairs)
    unit, matcher = with_unit_baseline(rig.extrinsics), with_measured_range(None, images)
    return ByTrueRig(rig, host.correspondences(images.at(1.0), unit, matcher), scene.name.startswith(MOVING))


def judged(scene: Scene, given: Scene, case: str, judge: ByTrueRig, options: argparse.Namespace) -> Iterator[Row]:
    """Repair a spoiled scene from every start."""
    kind = "misfit-explained" if case in EXPLAINED else f"misfit-{options.kind}"
    for name, (degrees, fraction) in STARTS.items():
        for draw in range(options.draws if degrees else 1):
            key = jax.random.fold_in(jax.random.key(zlib.crc32(f"{scene.name} {case}".encode())), draw)
            start = sr.synthetic.decalibrate(judge.true, key, degrees, fraction) if degrees else judge.true
            solution = sr.recalibrate(start, given.pairs)
            before, after = judge(start), judge(solution.rig)
            if not case.startswith((*OF_THE_MODEL, LATE)):
                Case.of(kind, f"{scene.name} | {case} | {name} {draw}", solution, judge).record(options.record)
            yield Row(
                scene.name,
                case,
                case in EXPLAINED,
                name,
                solution.reason.name,
                solution.accepted,
                after.worse_than(before),
                after.worse_than(before, ROWS_CHANGED),
                not solution.accepted and before.in_need,
                float(np.nan_to_num(after.depth - before.depth)),
            )


def repaired(options: argparse.Namespace) -> Iterator[Row]:
    """All scenes, spoiled in all ways."""
    kinds = KINDS[options.kind]
    for clean, late in scenes(options.frames):
        judge = None
        for case in (*kinds, *([LATE] if late is not None and options.kind == "seen" else [])):
            if not among(f"{clean.name} {case}", words(options.only)):
                continue
            if judge is None:
                scene = consensus(clean)
                judge = judge_of(scene)
            given = late if case == LATE else spoiled(scene, kinds[case], case)
            for row in judged(scene, given, case, judge, options):
                print(row.scene, row.case, row.start, row.reason, "harmful" * row.harmful, sep=" | ", flush=True)
                yield row


def main() -> None:
    """Spoil, repair, judge, print."""
    parser = command_line(__doc__)
    parser.add_argument("--draws", type=int, default=2, help="starts at 0.3° and at 2.5°, each")
    parser.add_argument("--only", default="", help="parts of names of scenes or cases, comma separated")
    kind = parser.add_mutually_exclusive_group()
    for name, what in (("unseen", "kinds that no rule was chosen on"), ("new", "ten more such")):
        kind.add_argument(f"--{name}", dest="kind", action="store_const", const=name, default="seen", help=what)
    parser.add_argument("--frames", type=int, default=1, help="of each scene, spoiled each by itself; rendered ones")
    parser.add_argument("--turning", action="store_true", help="late on a rig that only turns, and nothing else")
    parser.add_argument("--record", type=Path, help="a folder for replay.py")
    options = parser.parse_args()
    if options.turning:
        turning()
    else:
        show_rows(list(repaired(options)))


def show_rows(rows: list[Row]) -> None:
    """A line for each case, and for all of a kind."""
    starts = " | ".join(f"accepted: {start}" for start in STARTS)
    table = table_of(f"case | reasons | repairs | {starts} | harmful | missed | depth worse, at most", left=2)
    groups = {case: [r for r in rows if r.case == case] for case in dict.fromkeys(r.case for r in rows)}
    own = [r for r in rows if r.case.startswith(OF_THE_MODEL)]
    groups |= {
        "all explained": [r for r in rows if r.explained],
        "all unexplained": [r for r in rows if not r.explained and r not in own and r.case != LATE],
        "of the model, not counted": own,
    }
    for case, some in ((case, some) for case, some in groups.items() if some):
        of = [[r.accepted for r in some if r.start == start] for start in STARTS]
        harmful, changed, missed = (sum(getattr(r, name) for r in some) for name in ("harmful", "changed", "missed"))
        table.add_row(
            case,
            " ".join(sorted({r.reason for r in some})),
            f"{len(some)}",
            *(f"{sum(a)}/{len(a)}" for a in of),
            f"{harmful} ({changed})",
            f"{missed}",
            f"{max(r.depth_worse for r in some):+.1f} %",
        )
    show(table)


if __name__ == "__main__":
    main()
