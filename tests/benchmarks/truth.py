"""Are calibrations right, by what no estimate uses: lidar, chessboards, corners of scenes not looked at? Prints tables.

    python tests/benchmarks/truth.py [--judges lidar,boards,product] [--method NAME,…] [--from 2.5] [--draws N]
        [--only NAME,…]

Scenes: the folder STEREORECAL_DATA (default: ../shared/data beside the checkout). Every rig that a method names
(truth_methods.py: add yours to METHODS) meets the judges, accepted or not:

lidar: disparities of OpenCV's SGBM against depth that is known, and rows of corners that Lucas-Kanade followed.
boards: eleven chessboards that bumblebee2 saw, rows of their corners and the length of their squares, for rigs from
    each of its four scenes and from all as one rig.
product: eight scenes of one OAK-D, rows only: a rig from each scene on that scene and on the others; from seven, on
    the eighth.

Pixels are those of the stored left camera. Methods start from the stored rig, or with --from from one that is off by
up to so many degrees, and 0.9 % of the baseline for each. "yaw" is against the stored rig, with its stated interval.
HARMFUL: accepted, and against the start rows are worse by more than 0.02 px (boards: 0.05 px, since the stored rig was
fitted to them), or depth at 30 baselines by more than 1 % (boards: by the squares' error times 30 over the boards'
distance in baselines). "below stored": not so, but against the stored rig.
"""

import argparse
import os
import subprocess
from pathlib import Path

import cv2
import numpy as np
from product_errors import by_product, product_is_worse
from truth_methods import METHODS
from truth_runs import Options, Tally, finish, rig_of, stated, table_of

import stereorecal as sr
from stereorecal.comparison.judges import (
    BINS,
    ByBoards,
    DepthByTruth,
    by_boards,
    depth_by_truth,
    row_error_px,
    scene_with_truth,
)

CHECKOUT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STEREORECAL_DATA", CHECKOUT / "../shared/data"))
LIDAR = ("kitti2012/000000_10", "kitti2015/000001_10", "middlebury2014/motorcycle_quarter")
BOARDS, CORNERS, SQUARE = "boofcv_bumblebee2/calibration_chess", (4, 6), 0.030  # inner corners; metres
PRODUCT = "oak_d"
BUMBLEBEE = ("garden01", "stones01", "sundial01", "chair01")


def lidar(options: Options) -> None:
    """Depth by truth, a line for each rig."""
    bins = [f"{low}-{high} B" for low, high in BINS]
    heads = (
        "rows px",
        "disparity px",
        "corners px",
        *bins,
        "30 B %",
        "truth px",
        "matched",
        "yaw °",
        "stated at 30 B %",
    )
    table = table_of("depth by lidar and dense truth", ("scene", "rig", "verdict"), (*heads, "judged"))
    tally = Tally()

    def cells(seen: DepthByTruth) -> list[str]:
        depths = ["-" if np.isnan(error) else f"{error:+.1f}" for error in seen.depth_percent]
        numbers = [
            f"{seen.rows_px:.3f}",
            f"{seen.offset_px:+.2f}",
            f"{seen.corners_px:+.2f}",
            *depths,
            f"{seen.at_30_percent:.1f}",
        ]
        return [*numbers, f"{seen.truth_pixels}", f"{seen.matched}"]

    for name in (name for name in LIDAR if options.wants(name)):
        if not (DATA / name).exists():
            print(f"skipped: {DATA / name} is not there")
            continue
        scene = scene_with_truth(DATA / name)
        rig = rig_of(scene)
        stored = depth_by_truth(rig, rig, scene)
        table.add_row(name, "stored", "", *cells(stored), "", "", "")
        for task in options.tasks(name, rig, [scene]):
            before = depth_by_truth(task.start, rig, scene)
            if task.start is not rig:
                table.add_row(task.name, "start", "", *cells(before), "", "", "")
            for method, answer in options.answers(task):
                for label, judged in answer.judged.items():
                    after = depth_by_truth(judged, rig, scene)
                    worse, below = after.worse_than(before), after.worse_than(stored)
                    said = tally.add(method, answer, label, worse, below)
                    more = (*cells(after), *stated(answer, rig), said)
                    table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "lidar")


def boards(options: Options) -> None:
    """Chessboards, a line for each rig."""
    needed = [DATA / BOARDS, *(DATA / f"boofcv_bumblebee2/{name}" for name in BUMBLEBEE)]
    if missing := [str(folder) for folder in needed if not folder.exists()]:
        print(f"skipped: {', '.join(missing)} not there")
        return
    seen = sr.find_boards(sr.io.load_pairs(needed[0] / "left*.jpg", needed[0] / "right*.jpg"), CORNERS, SQUARE)
    scenes = [sr.io.load_scene(folder) for folder in needed[1:]]
    rig = rig_of(scenes[0])
    heads = ("boards' rows rms px", "mean px", "squares %", "spread %", "rows of the scenes px", "yaw °")
    stored = by_boards(rig, rig, seen)
    title = f"{len(seen)} chessboards of bumblebee2, at {stored.baselines:.1f} baselines"
    table = table_of(title, ("from", "rig", "verdict"), (*heads, "stated at 30 B %", "judged"))
    tally = Tally()

    def cells(judged: sr.StereoRig, found: ByBoards) -> list[str]:
        medians = " ".join(f"{row_error_px(judged, rig, scene):.2f}" for scene in scenes)
        numbers = (f"{found.rows_rms_px:.3f}", f"{found.rows_mean_px:+.3f}", f"{found.squares_percent:+.2f}")
        return [*numbers, f"{found.squares_spread_percent:.2f}", medians]

    table.add_row("", "stored", "", *cells(rig, stored), "", "", "")
    cases = {name: [scene] for name, scene in zip(BUMBLEBEE, scenes, strict=True)} | {"all four": scenes}
    for name in (name for name in cases if options.wants(name)):
        for task in options.tasks(name, rig, cases[name]):
            before = by_boards(task.start, rig, seen)
            if task.start is not rig:
                table.add_row(task.name, "start", "", *cells(task.start, before), "", "", "")
            for method, answer in options.answers(task):
                for label, judged in answer.judged.items():
                    after = by_boards(judged, rig, seen)
                    worse, below = after.worse_than(before), after.worse_than(stored)
                    said = tally.add(method, answer, label, worse, below)
                    more = (*cells(judged, after), *stated(answer, rig), said)
                    table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "boards")


def product(options: Options) -> None:
    """Scenes of a product, a line for each rig: itself, and the scenes that took no part."""
    folders = sorted(file.parent for file in (DATA / PRODUCT).glob("*/calib.json"))
    if len(folders) < 3:
        print(f"skipped: {DATA / PRODUCT} has too few scenes")
        return
    scenes = [sr.io.load_scene(folder) for folder in folders]
    rig = rig_of(scenes[0])
    heads = ("start px", "rows px", "others: median change px", "worst px", "yaw °", "stated at 30 B %", "judged")
    table = table_of(
        f"{len(scenes)} scenes of a product (depth not judged)", ("from", "rows of", "rig", "verdict"), heads
    )
    tally = Tally()
    for index, scene in enumerate(scenes):
        others = [other for other in scenes if other is not scene]
        name = folders[index].name
        for kind, given in ((name, [scene]), (f"all but {name}", others)):
            for task in options.tasks(kind, rig, given) if options.wants(kind) else ():
                before = by_product(task.start, rig, [scene, *others]).judged_px
                for method, answer in options.answers(task):
                    for label, judged in answer.judged.items():
                        after = by_product(judged, rig, [scene, *others])
                        change = np.subtract(after.judged_px, before)
                        unseen = slice(1, None) if given[0] is scene else slice(1)
                        worse, below = (product_is_worse(some, unseen) for some in (change, after.against_stored_px))
                        said = tally.add(method, answer, label, worse, below)
                        numbers = (f"{before[0]:.3f}", f"{after.judged_px[0]:.3f}", f"{np.median(change[unseen]):+.3f}")
                        more = (*numbers, f"{change[unseen].max():+.3f}", *stated(answer, rig), said)
                        table.add_row(task.name, name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "product")


def commit() -> str:
    """Of the checkout, and whether the library there is another."""

    def git(*words: str) -> str:
        return subprocess.run(("git", *words), cwd=CHECKOUT, capture_output=True, text=True, check=False).stdout.strip()

    return git("rev-parse", "--short", "HEAD") + (" and changes" if git("status", "--porcelain", "stereorecal") else "")


JUDGES = {"lidar": lidar, "boards": boards, "product": product}


def main() -> None:
    """Run methods, judge what they say, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--judges", default=",".join(JUDGES), help="comma separated")
    parser.add_argument("--method", default=",".join(METHODS), help="comma separated; none: the stored rigs alone")
    parser.add_argument("--from", dest="degrees", type=float, default=0.0, help="start so many degrees off")
    parser.add_argument("--draws", type=int, default=1, help="starts for each scene, with --from")
    parser.add_argument("--only", default="", help="parts of names of scenes, comma separated")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    methods, only = (tuple(word for word in text.split(",") if word) for text in (given.method, given.only))
    options = Options(methods, given.degrees, given.draws, only)
    start = f"{given.degrees}° off" if given.degrees else "the stored rigs"
    print(f"commit {commit()}; OpenCV {cv2.__version__}; from {start}; methods {', '.join(methods)}; data {DATA}")
    for judge in given.judges.split(","):
        JUDGES[judge](options)


if __name__ == "__main__":
    main()
