"""What freed intrinsics and ranges are worth, and what they may cost. Prints a table for each part.

    python tests/benchmarks/intrinsics.py [--rigs N] [--only PART,…]

Rendered rigs whose intrinsics are wrong as chessboards leave them (focal length 0.3 %, centre 1.5 px, k1 0.01, k2
0.02: one sigma, each camera by itself); eight scenes. Rows are those of points at ten baselines over the whole view, of
which no correspondence is known; depth is that straight ahead. (Real rigs: truth.py --method library-free.)

one (all scenes share the extrinsics), each (each has its own), place (eight frames of one place), ranges (one, with ten
ranges of 1 % at 5 to 40 baselines), right (intrinsics that are right).

long: 200 frames of 640x480 as a process of its own, with its time and its memory.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from tables import command_line, show, table_of, words

import stereorecal as sr
from stereorecal.geometry import Camera, changed_camera, view
from stereorecal.recalibration import depth_errors, row_errors_of

BOTH = ("extrinsics", "intrinsics")
SIGMAS = {"f": 0.3, "cx": 1.5, "cy": 1.5, "k1": 0.01, "k2": 0.02}  # of wrong intrinsics: percent, pixels
KINDS = ("harbour", "coast", "street")
TRUE = sr.synthetic.default_rig()
HEADS = "part | rows fixed | all, median / worst | taken, median / worst | |depth| at 10 / 30 B | taken | harmful"
REPAIRS = ("one", "each", "place", "ranges", "right")
PARTS = (*REPAIRS, "long")
FRAMES, RENDERED = 200, 8  # of a long recording; most are some with other noise and exposure


def wrong(seed: int) -> sr.StereoRig:
    """The true rig with intrinsics as a chessboard may leave them."""
    draw = np.random.default_rng(seed)

    def camera(given: Camera) -> Camera:
        units = {"f": 0.01}
        return changed_camera(given, {n: sigma * units.get(n, 1.0) * draw.normal() for n, sigma in SIGMAS.items()})

    return replace(TRUE, left=camera(TRUE.left), right=camera(TRUE.right))


def rows(rig: sr.StereoRig) -> float:
    """Root mean square over the view, pixels."""
    apart = row_errors_of(rig, TRUE, view(rig), np.linspace(0, 639, 33), np.linspace(0, 479, 25))[0]
    return float(np.sqrt(np.nanmean(apart**2)))


def scenes(number: int = 8) -> list[sr.Scene]:
    """Different ones of three kinds."""
    return [sr.synthetic.render(KINDS[i % 3], 10 + i) for i in range(number)]


def some_ranges(kind: str, seed: int, pair: sr.Pair | int, number: int, draw: int) -> list[sr.Range]:
    """Ranges of 1 % noise at 5 to 40 baselines."""
    pixels, metres = sr.synthetic.ranges(kind, seed, number=number, draw=draw)
    return [sr.Range(pair, (p[0], p[1]), m) for p, m in zip(pixels.tolist(), metres.tolist(), strict=True)]


def repaired(given: Sequence[sr.Scene], seed: int, rig: sr.StereoRig, part: str) -> Iterator[tuple]:
    """The errors of the rig in use after each repair: rows where lenses are held, rows where they are free, depth at 10
    and 30 baselines; also whether the intrinsics were taken, and harm."""
    ranges = some_ranges(KINDS[0], 10, given[0].pairs[0], 10, seed) if part == "ranges" else []
    if part == "each":
        some = [replace(s, rig=rig) for s in given]
        held, found = ([r.solution for r in sr.recalibrate_many(some, free=free)] for free in ("extrinsics", BOTH))
    else:
        pairs = [s.pairs[0] for s in given]
        held = [sr.recalibrate(rig, pairs, free="extrinsics")]
        found = [sr.recalibrate(rig, pairs, free=BOTH, ranges=ranges)]
    for fixed, solution in zip(held, found, strict=True):
        assert fixed is not None
        assert solution is not None
        depth = depth_errors(solution.rig, TRUE)
        off = (rows(fixed.rig), rows(solution.rig), depth[10], depth[30])
        taken = solution.intrinsics is not None and solution.intrinsics.taken
        yield (*off, taken, harmful(solution, fixed))


def harmful(solution: sr.Solution, fixed: sr.Solution) -> bool:
    """Whether the rig in use is worse than what the extrinsics alone would have given: rows over the view, or depth
    that lies outside of what was said to expect and farther off than before."""
    if not solution.accepted:
        return False
    if rows(solution.rig) > rows(fixed.rig) + 0.02:
        return True
    said, now, before = solution.expected, depth_errors(solution.rig, TRUE), depth_errors(fixed.rig, TRUE)
    return said is not None and any(
        abs(now[d]) > abs(before[d]) and not said.depth_percent[d].low <= now[d] <= said.depth_percent[d].high
        for d in (10, 30)
    )


def repairs(part: str, rigs: int) -> list[str]:
    """One line of the table."""
    given = scenes()
    if part == "place":
        many = sr.synthetic.render("harbour", 10, frames=8)
        given = [replace(many, name=pair.name, pairs=(pair,)) for pair in many.pairs]
    found, accepted = [], []
    for seed in range(rigs):
        some = list(repaired(given, seed, TRUE if part == "right" else wrong(seed), part))
        accepted.append(some[0][4])
        found += some
        print(part, seed, *(np.round(row, 3).tolist() for row in some), flush=True)
    values = np.array(found, float)
    taken = values[values[:, 4] > 0]

    def middle_and_worst(some: np.ndarray) -> str:
        return f"{np.median(some[:, 1]):.3f} / {some[:, 1].max():.3f}" if len(some) else ""

    return [
        part,
        f"{np.median(values[:, 0]):.2f}",
        middle_and_worst(values),
        middle_and_worst(taken),
        f"{np.median(np.abs(values[:, 2])):.2f} / {np.median(np.abs(values[:, 3])):.2f} %",
        f"{sum(accepted)} of {rigs}",
        f"{int(values[:, 5].sum())} of {len(values)}",
    ]


def long_recording() -> None:
    """Write the frames, repair them on the command line, print."""
    with tempfile.TemporaryDirectory() as folder:
        written(Path(folder))
        options = ["--free", "extrinsics,intrinsics", "--limit", "all", "--quiet"]
        command = [sys.executable, "-m", "stereorecal", "recalibrate", folder, *options]
        began = time.perf_counter()
        process = subprocess.Popen(command)
        _, status, used = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - began
    print(
        f"{FRAMES} frames of 640x480, extrinsics and intrinsics: {seconds:.0f} s, {used.ru_maxrss / 1024:.0f} MB, "
        f"exit code {os.waitstatus_to_exitcode(status)}"
    )


def written(folder: Path) -> None:
    pairs = [sr.synthetic.render(KINDS[i % 3], 10 + i).pairs[0] for i in range(RENDERED)]
    for side in ("left", "right"):
        (folder / side).mkdir()
        for frame in range(FRAMES):
            draw = np.random.default_rng([frame, side == "right"])
            image = np.asarray(getattr(pairs[frame * RENDERED // FRAMES], side), float)
            image = (1.0 + 0.1 * np.sin(frame)) * image + draw.normal(0.0, 2.0, image.shape)
            cv2.imwrite(str(folder / side / f"{frame:04}.png"), np.clip(image, 0, 255).round().astype(np.uint8))
    sr.io.save_rig(wrong(0), folder / "calib.json")


def main() -> None:
    """Run the parts, print their tables."""
    parser = command_line(__doc__)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--only", default=",".join(PARTS), help="parts, comma separated")
    options = parser.parse_args()
    parts, table = words(options.only), table_of(HEADS)
    for part in (part for part in REPAIRS if part in parts):
        table.add_row(*repairs(part, options.rigs))
    if table.row_count:
        show(table)
    if "long" in parts:
        long_recording()


if __name__ == "__main__":
    main()
