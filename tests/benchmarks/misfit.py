"""Is a good rig ever replaced by a bad one, where five parameters cannot explain the images? Prints two tables.

    python tests/benchmarks/misfit.py [--draws N] [--frames N] [--only NAME,…] [--unseen | --new] [--part I/N]
        [--json FILE]
    python tests/benchmarks/misfit.py --turning

Rendered and real scenes are spoiled in many ways, half of which the model explains (noise, blur, exposure, JPEG from
20 on, glints, rain, fixed dirt) and half of which it does not, and repaired from the true rig, from 0.3° and from 2.5°
away; with several frames, what moves does so differently in each. Judges: rows by correspondences that were found on
the CLEAN images under the true rig, depth at 30 baselines by the true rig (not of real scenes: what stands there
for the true rig is the consensus of repairs of the clean images). Harmful: accepted, and the median row error grown by
more than 0.02 px, or the median error of depth by more than a percentage point. Kinds that parameters of the model
explain, so that no image can tell them from a rig, are printed by themselves and not counted.

With --turning: what no single frame can tell, a late right image on a rig that only turns, which is another pose of the
right camera, exactly.
"""

import argparse
import json
import os
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import jax
import numpy as np
from accuracy import consensus, errors
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.estimation import readings
from stereorecal.estimation._consequences import points_of_view
from stereorecal.geometry import with_unit_baseline
from stereorecal.objectives import read_by
from stereorecal.recordings import Scene
from stereorecal.scoring import host, median_row_error, pyramid
from stereorecal.scoring.host import with_measured_range

Images = tuple[np.ndarray, np.ndarray]
Spoil = Callable[[np.ndarray, np.ndarray, np.random.Generator], Images]
RENDERED = [(kind, seed) for kind in ("harbour", "coast", "street") for seed in (1, 2)]
REAL = (
    "boofcv_bumblebee2/garden01",
    "euroc/vicon_room_seq",
    "kitti_odometry/suburb_seq",
    "middlebury2014/motorcycle_quarter",
)
ROWS_WORSE, DEPTH_WORSE = 0.02, 1.0  # pixels, percentage points: what counts as harm
STARTS = {"true": (0.0, 0.0), "0.3°": (0.3, 0.003), "2.5°": (2.5, 0.0225)}


# --- what the model explains -------------------------------------------------------------------------------


def noise(sigma: float) -> Spoil:
    return lambda left, right, draw: (
        left + draw.normal(0, sigma, left.shape),
        right + draw.normal(0, sigma, left.shape),
    )


def blur(sigma: float) -> Spoil:
    return lambda left, right, draw: (left, cv2.GaussianBlur(right, (0, 0), sigma))


def exposure(gain: float, gamma: float) -> Spoil:
    return lambda left, right, draw: (left, 255 * (right / 255) ** gamma * gain)


def jpeg(quality: int) -> Spoil:
    def coded(image: np.ndarray) -> np.ndarray:
        bytes_ = cv2.imencode(".jpg", image.round().clip(0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])[
            1
        ]
        return cv2.imdecode(bytes_, cv2.IMREAD_GRAYSCALE).astype(float)

    return lambda left, right, draw: (coded(left), coded(right))


def spots(number: int, value: float, both: bool) -> Spoil:
    """Glints, or dirt on a lens."""

    def drawn(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        image = image.astype(np.float32).copy()
        for _ in range(number):
            centre = int(draw.integers(0, width)), int(draw.integers(0, height))
            axes = tuple(int(a) for a in draw.integers(1, max(3, width // 70), 2))
            cv2.ellipse(image, centre, axes, 0.0, 0.0, 360.0, value, -1)
        return image

    return lambda left, right, draw: (drawn(left, draw) if both else left, drawn(right, draw))


def rain(number: int) -> Spoil:
    def drawn(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        layer = np.zeros_like(image, np.float32)
        for _ in range(number):
            x, y, length = int(draw.integers(0, width)), int(draw.integers(0, height)), int(draw.integers(8, 25))
            cv2.line(layer, (x, y), (x + length // 6, y + length), float(draw.uniform(20, 60)), 1)
        return image + cv2.GaussianBlur(layer, (0, 0), 0.8)

    return lambda left, right, draw: (drawn(left, draw), drawn(right, draw))


EXPLAINED: dict[str, Spoil] = {
    "clean": lambda left, right, draw: (left, right),
    "noise 5": noise(5),
    "noise 12": noise(12),
    "blur 1": blur(1.0),
    "blur 2": blur(2.0),
    "darker": exposure(0.65, 1.15),
    "brighter": exposure(1.2, 0.9),
    "jpeg 20": jpeg(20),
    "jpeg 60": jpeg(60),
    "glints": spots(300, 255.0, True),
    "rain": rain(600),
    "dirt": spots(25, 60.0, False),
}

# --- what it does not --------------------------------------------------------------------------------------


def warped(of_rows: Callable, of_columns: Callable) -> Spoil:
    """The right image, taken from (x + of_columns, y + of_rows), both functions of x and y from -1 to 1, in pixels."""

    def spoil(left, right, draw):
        height, width = right.shape
        y, x = np.mgrid[:height, :width].astype(np.float32)
        u, v = 2 * x / (width - 1) - 1, 2 * y / (height - 1) - 1
        there = (x + of_columns(u, v)).astype(np.float32), (y + of_rows(u, v)).astype(np.float32)
        return left, cv2.remap(right.astype(np.float32), *there, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

    return spoil


def none(u, v):
    return 0.0 * u


def patch(share: float, rows: float, columns: float = 0.0, shape: str = "block") -> Spoil:
    """A part of the right image has moved: a ship, a wave, a tree."""

    def spoil(left, right, draw):
        height, width = right.shape
        y, x = np.mgrid[:height, :width].astype(np.float32)
        if shape == "block":
            h, w = int(height * share**0.5), int(width * share**0.5)
            top, first = int(draw.integers(0, height - h + 1)), int(draw.integers(0, width - w + 1))
            inside = (y >= top) & (y < top + h) & (x >= first) & (x < first + w)
        elif shape == "left":
            inside = x < share * width
        else:
            inside = y > (1 - share) * height
        there = (x + np.float32(columns) * inside, y + np.float32(rows) * inside)
        return left, cv2.remap(right.astype(np.float32), *there, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

    return spoil


def interlaced(columns: float, rows: float) -> Spoil:
    """Every other row of the right image is of a later field."""

    def spoil(left, right, draw):
        later = warped(lambda u, v: rows + none(u, v), lambda u, v: columns + none(u, v))(left, right, draw)[1]
        mixed = right.copy()
        mixed[1::2] = later[1::2]
        return left, mixed

    return spoil


def stretched(percent: float) -> Spoil:
    return lambda left, right, draw: warped(lambda u, v: percent / 200 * right.shape[0] * v, none)(left, right, draw)


def sheared(percent: float) -> Spoil:
    return lambda left, right, draw: warped(none, lambda u, v: percent / 200 * right.shape[0] * v)(left, right, draw)


def rolling(rows: float, columns: float) -> Spoil:
    """A rolling shutter in the right camera alone, of a rig that turns: the lower, the later."""
    return warped(lambda u, v: rows * (v + 1) / 2, lambda u, v: columns * (v + 1) / 2)


UNEXPLAINED: dict[str, Spoil] = {
    "patch 20 %, 1 row": patch(0.2, 1),
    "patch 20 %, 3 rows": patch(0.2, 3),
    "patch 40 %, 1 row": patch(0.4, 1),
    "patch 40 %, 2 rows": patch(0.4, 2),
    "patch 60 %, 3 rows": patch(0.6, 3),
    "left 30 %, 2 rows": patch(0.3, 2, 0, "left"),
    "below 40 %, 1 row": patch(0.4, 1, 0, "below"),
    "stretched 0.1 %": stretched(0.1),
    "stretched 0.5 %": stretched(0.5),
    "sheared 0.3 %": sheared(0.3),
    "sheared 1 %": sheared(1.0),
    "rolling 1 row, 3 columns": rolling(1, 3),
    "rolling 3 rows": rolling(3, 0),
    "interlaced 2 columns": interlaced(2, 0),
    "jpeg 5": jpeg(5),
    "jpeg 10": jpeg(10),
}
# First run once the rules stood.
UNSEEN: dict[str, Spoil] = {
    "patch 30 %, 2 rows, 3 columns": patch(0.3, 2, 3),
    "patch 50 %, 1 row": patch(0.5, 1),
    "patch 50 %, 3 rows": patch(0.5, 3),
    "patch 20 %, 2 rows": patch(0.2, 2),
    "left 50 %, 1 row": patch(0.5, 1, 0, "left"),
    "below 25 %, 3 rows": patch(0.25, 3, 4, "below"),
    "stretched 0.3 %": stretched(0.3),
    "stretched 1 %": stretched(1.0),
    "sheared 0.1 %": sheared(0.1),
    "rolling 2 rows, 6 columns": rolling(2, 6),
    "rolling 0.5 rows, 10 columns": rolling(0.5, 10),
    "interlaced 1 row": interlaced(0, 1),
    "barrel": warped(lambda u, v: 1.5 * v * (u * u + v * v), lambda u, v: 1.5 * u * (u * u + v * v)),
    "keystone": warped(lambda u, v: 1.0 * u * v, none),
    "jpeg 15": jpeg(15),
}
# A third group, written before the rule that whole regions must not be lost, and never looked at while it was made.


def smooth_field(pixels: float, grain: float) -> Spoil:
    """Rows and columns of the right image displaced by a smooth random field: haze over hot ground, water on glass."""

    def spoil(left, right, draw):
        height, width = right.shape
        sigma = grain * width

        def field() -> np.ndarray:
            drawn = cv2.GaussianBlur(draw.normal(0, 1, (height, width)).astype(np.float32), (0, 0), sigma)
            return pixels * drawn / drawn.std()

        y, x = np.mgrid[:height, :width].astype(np.float32)
        there = (x + field()).astype(np.float32), (y + field()).astype(np.float32)
        return left, cv2.remap(right.astype(np.float32), *there, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

    return spoil


def crowd(number: int, share: float, rows: float) -> Spoil:
    """Several things, each with a motion of its own."""

    def spoil(left, right, draw):
        for _ in range(number):
            motion = draw.uniform(-rows, rows), draw.uniform(-2 * rows, 2 * rows)
            left, right = patch(share, *motion)(left, right, draw)
        return left, right

    return spoil


def turned_patch(share: float, degrees: float) -> Spoil:
    """A part that has turned: a boat that rolls."""

    def spoil(left, right, draw):
        height, width = right.shape
        side = float(np.sqrt(share * height * width))
        centre = draw.uniform(0.3, 0.7) * width, draw.uniform(0.3, 0.7) * height
        whole = cv2.warpAffine(
            right.astype(np.float32),
            cv2.getRotationMatrix2D(centre, degrees, 1.0),
            (width, height),
            flags=cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REPLICATE,
        )
        y, x = np.mgrid[:height, :width]
        inside = np.hypot(x - centre[0], y - centre[1]) < side / np.sqrt(np.pi)
        return left, np.where(inside, whole, right)

    return spoil


def blocks(pixels: float) -> Spoil:
    """A video codec that moves blocks of 16 pixels by its own motion vectors, in both images."""

    def coded(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        number = -(-height // 16), -(-width // 16)
        y, x = np.mgrid[:height, :width].astype(np.float32)
        moved = [np.kron(draw.choice([-pixels, 0.0, 0.0, pixels], number), np.ones((16, 16))) for _ in "yx"]
        there = [(at + one[:height, :width]).astype(np.float32) for at, one in zip((y, x), moved, strict=True)]
        return cv2.remap(image.astype(np.float32), there[1], there[0], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)

    return lambda left, right, draw: (coded(left, draw), coded(right, draw))


def veil(share: float) -> Spoil:
    """The sun beside one lens: a part of the image is white."""

    def spoil(left, right, draw):
        height, width = right.shape
        y, x = np.mgrid[:height, :width]
        away = np.hypot(x - draw.uniform(0, width), y - draw.uniform(0, height / 3))
        return left, right + 255.0 * np.exp(-((away / (share * width)) ** 2))

    return spoil


def focus(sigma: float) -> Spoil:
    """One lens that is out of focus to one side."""

    def spoil(left, right, draw):
        sharp, soft = right, cv2.GaussianBlur(right, (0, 0), sigma)
        weight = np.linspace(0.0, 1.0, right.shape[1])
        return left, (1.0 - weight) * sharp + weight * soft

    return spoil


def bar(share: float) -> Spoil:
    """A wiper, or a rope, before one camera: other rows behind it, none of them right."""

    def spoil(left, right, draw):
        height, width = right.shape
        y, x = np.mgrid[:height, :width]
        inside = np.abs(x - width / 2 - (y - height / 2) * draw.uniform(-1, 1)) < share * width / 2
        return left, np.where(inside, 40.0 + draw.normal(0, 3, right.shape), right)

    return spoil


NEW: dict[str, Spoil] = {
    "haze 0.7 px": smooth_field(0.7, 0.03),
    "water on glass 2 px": smooth_field(2.0, 0.15),
    "crowd of 5": crowd(5, 0.08, 3.0),
    "turned part": turned_patch(0.3, 1.0),
    "vibration 1 row": warped(lambda u, v: np.sin(9.0 * v) + none(u, v), none),
    "band 25 %, 2 rows": warped(lambda u, v: 2.0 * (np.abs(v - 0.1) < 0.25) + none(u, v), none),
    "codec blocks": blocks(1.0),
    "veil": veil(0.35),
    "focus to one side": focus(3.0),
    "wiper": bar(0.15),
}
# A yaw, every other line half a row of pitch, a focal length, a lens: parameters of the model, to the last pixel.
OF_THE_MODEL = ("keystone", "interlaced 1 row", "stretched", "barrel")
# What a motion makes of the images; with several frames it differs from one to the next.
MOVING = ("patch", "left", "below", "rolling", "interlaced", "crowd", "turned", "vibration", "band", "haze")
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
    depth_worse: float
    rows_before: float
    rows_after: float
    seconds: float
    features: dict


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


def judged(scene: Scene, given: Scene, case: str, explained: bool, draws: int, judge) -> Iterator[Row]:
    """Repair a spoiled scene from every start."""
    rig = scene.rig
    assert rig is not None
    for name, (degrees, fraction) in STARTS.items():
        for draw in range(draws if degrees else 1):
            key = jax.random.fold_in(jax.random.key(zlib.crc32(f"{scene.name} {case}".encode())), draw)
            start = sr.synthetic.decalibrate(rig, key, degrees, fraction) if degrees else rig
            solution = sr.recalibrate(start, given.pairs)
            rows = [
                median_row_error(read_by(judge, rig, r), with_unit_baseline(r.extrinsics))
                for r in (start, solution.rig)
            ]
            farther = depth_error(solution.rig, rig) - depth_error(start, rig)
            if not scene.name.startswith(tuple(kind for kind, _ in RENDERED)):
                farther = 0.0
            harmful = solution.accepted and (rows[1] > rows[0] + ROWS_WORSE or farther > DEPTH_WORSE)
            yield Row(
                scene.name,
                case,
                explained,
                name,
                len(given.pairs),
                solution.reason.name,
                solution.accepted,
                harmful,
                farther if solution.accepted else 0.0,
                *rows,
                solution.seconds,
                features(solution),
            )


def depth_error(used: sr.StereoRig, true: sr.StereoRig) -> float:
    """|Error of depth| at 30 baselines in percent, median over the view; what lies beyond infinity counts as ten times
    as far."""
    _, nearness = readings(used, true, points_of_view(true, 30))
    return 100.0 * abs(1.0 / max(1.0 + float(np.median(nearness)), 0.1) - 1.0)


def features(solution: sr.Solution) -> dict:
    """What the verdict rests on."""
    if solution.misfit is None or solution.uncertainty is None or solution.row_errors is None:
        return {}
    known = solution.uncertainty
    return {
        **solution.misfit.as_dict(),
        "row_errors": vars(solution.row_errors),
        "change": errors(solution.candidate, solution.initial).tolist(),
        "interval": known.interval.tolist(),
        "counts": [solution.score_before.count, solution.score_after.count],
    }


def spoiled(scene: Scene, spoil: Spoil, case: str) -> Scene:
    pairs = []
    for index, pair in enumerate(scene.pairs):
        draw = np.random.default_rng([zlib.crc32(case.encode()), index])
        images = spoil(np.asarray(pair.left, float), np.asarray(pair.right, float), draw)
        if index and case.startswith(MOVING):  # frames whose motions differ: the other way round, or at rest
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
    parser.add_argument("--turning", action="store_true", help="late on a rig that only turns, and nothing else")
    parser.add_argument("--part", default="0/1", help="every N-th case from the I-th on, for several processes")
    parser.add_argument("--json", type=Path, help="a line for each repair, appended")
    options = parser.parse_args()
    if options.turning:
        turning()
        return
    wanted = [part for part in options.only.split(",") if part]
    part, parts = map(int, options.part.split("/"))
    rows, number = [], 0
    for clean, late in scenes(options.frames):
        scene = judge = None
        kinds = NEW if options.new else UNSEEN if options.unseen else {**EXPLAINED, **UNEXPLAINED}
        cases = [*kinds, *([LATE] if late is not None and not (options.unseen or options.new) else [])]
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
                judge = host.correspondences(
                    images.at(1.0), with_unit_baseline(scene.rig.extrinsics), with_measured_range(None, images)
                )
            given = spoiled(scene, kinds[case], case) if case != LATE else replace(late, rig=scene.rig)
            for row in judged(scene, given, case, case in EXPLAINED, options.draws, judge):
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
    heads = ("case", "repairs", "accepted: true", "0.3°", "2.5°", "harmful", "depth worse, at most", "reasons")
    for head in heads:
        table.add_column(head, justify="left" if head in ("case", "reasons") else "right")
    groups = {case: [r for r in rows if r.case == case] for case in dict.fromkeys(r.case for r in rows)}
    own = [r for r in rows if r.case.startswith(OF_THE_MODEL)]
    groups |= {
        "all explained": [r for r in rows if r.explained],
        "all unexplained": [r for r in rows if not r.explained and r not in own],
        "of the model, not counted": own,
    }
    for case, some in groups.items():
        if not some:
            continue
        of = [[r.accepted for r in some if r.start == start] for start in STARTS]
        worst = max(r.depth_worse for r in some)
        reasons = " ".join(sorted({r.reason for r in some}))
        accepted = [f"{sum(a)}/{len(a)}" for a in of]
        table.add_row(case, f"{len(some)}", *accepted, f"{sum(r.harmful for r in some)}", f"{worst:+.1f} %", reasons)
    Console(width=200).print(table)


if __name__ == "__main__":
    main()
