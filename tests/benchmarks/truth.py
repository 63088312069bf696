"""Are calibrations right, by what no estimate uses: lidar, chessboards, scenes and frames that took no part? Tables.

    python tests/benchmarks/truth.py [--judges lidar,boards,few,sequence,wide] [--method NAME,…] [--from 2.5]
        [--draws N] [--only NAME,…] [--record FOLDER]

Scenes: the folder STEREORECAL_DATA (default: ../shared/data beside the checkout). Every rig that a method names
(truth_methods.py: add yours to METHODS) meets the judges, accepted or not:

lidar: disparities of OpenCV's SGBM against depth that is known, and rows of corners that Lucas-Kanade followed.
boards: eleven chessboards that bumblebee2 saw, rows of their corners and the length of their squares, for rigs from
    each of its four scenes and from all as one rig.
few: eight scenes of one OAK-D and four of bumblebee2, by one, two, three and four; rows of the scenes that took no
    part, of bumblebee2 boards as well.
sequence: EuRoC's vicon room, the frames that took no part; and KITTI's suburb.
wide: rows of SIFT's matches in a hall, through a fisheye.

Pixels are those of the stored left camera. Methods start from the stored rig, or with --from from one that is off by
up to so many degrees, and 0.9 % of the baseline for each. "yaw" is against the stored rig, with its stated interval.
HARMFUL: accepted, and against the start rows are worse by more than 0.05 px, or depth at 30 baselines by more than 1 %
(boards: by the squares' error times 30 over the boards' distance in baselines). "below stored": not so, but against the
stored rig. MISSED: rows of the start are worse than 0.2 px, and it stays.
"""

import argparse
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import stereorecal_boards
from recorded import ByChessboards, ByCorners, ByDepth, BySift
from sift_rows import sift_matches, sift_rows
from stereorecal_boards import Board
from stereorecal_field.judges import (
    BINS,
    ROWS_WORSE,
    ByBoards,
    DepthByTruth,
    by_boards,
    depth_by_truth,
    row_error_px,
    scene_with_truth,
)
from truth_methods import METHODS
from truth_runs import Options, Tally, finish, rig_of, stated, table_of

import stereorecal as sr

CHECKOUT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STEREORECAL_DATA", CHECKOUT / "../shared/data"))
LIDAR = ("kitti2012/000000_10", "kitti2015/000001_10", "middlebury2014/motorcycle_quarter")
BOARDS, CORNERS, SQUARE = "boofcv_bumblebee2/calibration_chess", (4, 6), 0.030  # inner corners; metres
OAK = ("bedroom_chair", "cycles", "desk", "donkey_toy", "kid_bedroom", "pov_controllers", "selfie", "toy")
WIDE = "mynteye_fisheye/hall"
SEQUENCES = {
    "euroc/vicon_room_seq": {"odd": slice(0, None, 2), "even": slice(1, None, 2), "all": slice(None)},
    "kitti_odometry/suburb_seq": {"first": slice(1), "all": slice(None)},
}
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
            for method, answer in options.answers(task, "lidar", ByDepth(rig, scene)):
                for label, judged in answer.judged.items():
                    after = depth_by_truth(judged, rig, scene)
                    worse, below = after.worse_than(before), after.worse_than(stored)
                    said = tally.add(method, answer, label, worse, below, need=before.rows_px)
                    more = (*cells(after), *stated(answer, rig), said)
                    table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "lidar")


def boards(options: Options) -> None:
    """Chessboards, a line for each rig."""
    needed = [DATA / BOARDS, *(DATA / f"boofcv_bumblebee2/{name}" for name in BUMBLEBEE)]
    if missing := [str(folder) for folder in needed if not folder.exists()]:
        print(f"skipped: {', '.join(missing)} not there")
        return
    seen = find_boards()
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
            need = float(np.median([row_error_px(task.start, rig, scene) for scene in task.scenes]))
            if task.start is not rig:
                table.add_row(task.name, "start", "", *cells(task.start, before), "", "", "")
            for method, answer in options.answers(task, "boards", ByChessboards(rig, seen)):
                for label, judged in answer.judged.items():
                    after = by_boards(judged, rig, seen)
                    worse, below = after.worse_than(before), after.worse_than(stored)
                    said = tally.add(method, answer, label, worse, below, need=need)
                    more = (*cells(judged, after), *stated(answer, rig), said)
                    table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "boards")


def few(options: Options) -> None:
    """A line for each rig of a few scenes: rows of these, and of the scenes that took no part."""
    seen = find_boards()
    for rig_name, names, numbers in (("oak_d", OAK, (1, 2, 3, 4)), ("boofcv_bumblebee2", BUMBLEBEE, (1, 2, 4))):
        folders = [DATA / rig_name / name for name in names]
        if missing := [str(folder) for folder in folders if not folder.exists()]:
            print(f"skipped: {', '.join(missing)} not there")
            continue
        scenes = [sr.io.load_scene(folder) for folder in folders]
        rig = rig_of(scenes[0])
        heads = ("own px", "unseen: median px", "worst growth px", "boards px", "squares %", "yaw °", "depth at 30 B %")
        table = table_of(f"few scenes of {rig_name}", ("from", "rig", "verdict"), (*heads, "judged"))
        tally, boards_seen = Tally(), seen if rig_name.startswith("boofcv") else None
        for number in numbers:
            after_all = []
            for first in range(0, len(scenes) - number + 1, number):
                chosen = range(first, first + number)
                kind = f"{number}: {' '.join(names[index] for index in chosen)}"
                rest = [index for index in range(len(scenes)) if index not in chosen] or list(chosen)
                others = ByCorners.of(rig, [scenes[index] for index in rest])
                for task in options.tasks(kind, rig, [scenes[i] for i in chosen]) if options.wants(kind) else ():
                    before = [row_error_px(task.start, rig, scene) for scene in scenes]
                    for method, answer in options.answers(task, "few", others):
                        for label, judged in answer.judged.items():
                            after = [row_error_px(judged, rig, scene) for scene in scenes]
                            growth = np.subtract(after, before)
                            worse = bool(np.median(growth[rest]) > ROWS_WORSE or np.mean(growth[chosen]) > ROWS_WORSE)
                            board_cells = ("", "")
                            if boards_seen is not None:
                                found, start = (by_boards(one, rig, boards_seen) for one in (judged, task.start))
                                worse = worse or (len(rest) == len(chosen) and found.worse_than(start))
                                board_cells = (f"{found.rows_rms_px:.3f}", f"{found.squares_percent:+.3f}")
                            said = tally.add(method, answer, label, worse, False, need=float(np.median(before)))
                            if label == "accepted":
                                after_all.append(float(np.median(np.array(after)[rest])))
                            own, unseen = (
                                [float(np.median(np.array(rows)[which])) for rows in (before, after)]
                                for which in (list(chosen), rest)
                            )
                            cells = (
                                f"{own[0]:.2f} -> {own[1]:.2f}",
                                f"{unseen[0]:.3f} -> {unseen[1]:.3f}",
                                f"{growth[rest].max():+.3f}",
                            )
                            more = (*cells, *board_cells, *stated(answer, rig), said)
                            table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
            if after_all:
                print(f"{rig_name}, by {number}: unseen rows {np.median(after_all):.3f} px, median of those accepted")
        finish(table, tally, f"few scenes of {rig_name}")


def find_boards() -> list[Board]:
    """The chessboards of bumblebee2; none, if they are not there."""
    folder = DATA / BOARDS
    return stereorecal_boards.find_boards(
        sr.io.load_pairs(folder / "left*.jpg", folder / "right*.jpg"), CORNERS, SQUARE
    )


def sequence(options: Options) -> None:
    """A line for each rig of some frames of a sequence: rows of these, and of the other frames."""
    heads = ("own px", "others: median px", "worst growth px", "yaw °", "depth at 30 B %", "judged")
    table = table_of("frames of a sequence", ("from", "rig", "verdict"), heads)
    tally = Tally()
    for name, choices in SEQUENCES.items():
        if not (DATA / name).exists():
            print(f"skipped: {DATA / name} is not there")
            continue
        whole = sr.io.load_scene(DATA / name)
        rig = rig_of(whole)
        frames = [replace(whole, pairs=(pair,)) for pair in whole.pairs]
        for kind, chosen in choices.items():
            own = list(range(len(frames)))[chosen]
            rest = [index for index in range(len(frames)) if index not in own] or own
            judge, whole_name = ByCorners.of(rig, [frames[i] for i in rest]), f"{name} {kind}"
            for task in options.tasks(whole_name, rig, [frames[i] for i in own]) if options.wants(whole_name) else ():
                before = np.array([row_error_px(task.start, rig, frame) for frame in frames])
                for method, answer in options.answers(task, "sequence", judge):
                    for label, judged in answer.judged.items():
                        after = np.array([row_error_px(judged, rig, frame) for frame in frames])
                        worse = bool(np.median((after - before)[rest]) > ROWS_WORSE)
                        said = tally.add(method, answer, label, worse, False, need=float(np.median(before)))
                        cells = [f"{np.median(before[k]):.3f} -> {np.median(after[k]):.3f}" for k in (own, rest)]
                        more = (*cells, f"{(after - before)[rest].max():+.3f}", *stated(answer, rig), said)
                        table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "sequence")


def wide(options: Options) -> None:
    """A line for each rig of the hall: rows of features that no method looks at."""
    if not (DATA / WIDE).exists():
        print(f"skipped: {DATA / WIDE} is not there")
        return
    scene = sr.io.load_scene(DATA / WIDE)
    rig, tally = rig_of(scene), Tally()
    table = table_of(
        "a fisheye, by SIFT", ("from", "rig", "verdict"), ("rows px", "yaw °", "depth at 30 B %", "judged")
    )
    matches = sift_matches(rig, scene.pairs[0])
    for task in options.tasks(WIDE, rig, [scene]) if options.wants(WIDE) else ():
        before = sift_rows(task.start, matches)
        for method, answer in options.answers(task, "wide", BySift(matches)):
            for label, judged in answer.judged.items():
                after = sift_rows(judged, matches)
                said = tally.add(method, answer, label, after > before + ROWS_WORSE, False, need=before)
                more = (f"{before:.3f} -> {after:.3f}", *stated(answer, rig), said)
                table.add_row(task.name, f"{method} {label}", answer.verdict, *more)
    finish(table, tally, "wide")


def commit() -> str:
    """Of the checkout, and whether the library there is another."""

    def git(*words: str) -> str:
        return subprocess.run(("git", *words), cwd=CHECKOUT, capture_output=True, text=True, check=False).stdout.strip()

    return git("rev-parse", "--short", "HEAD") + (" and changes" if git("status", "--porcelain", "stereorecal") else "")


JUDGES = {"lidar": lidar, "boards": boards, "few": few, "sequence": sequence, "wide": wide}


def main() -> None:
    """Run methods, judge what they say, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--judges", default=",".join(JUDGES), help="comma separated")
    parser.add_argument("--method", default=",".join(METHODS), help="comma separated; none: the stored rigs alone")
    parser.add_argument("--from", dest="degrees", type=float, default=0.0, help="start so many degrees off")
    parser.add_argument("--draws", type=int, default=1, help="starts for each scene, with --from")
    parser.add_argument("--only", default="", help="parts of names of scenes, comma separated")
    parser.add_argument("--record", type=Path, help="a folder for replay.py")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    methods, only = (tuple(word for word in text.split(",") if word) for text in (given.method, given.only))
    options = Options(methods, given.degrees, given.draws, only, given.record)
    start = f"{given.degrees}° off" if given.degrees else "the stored rigs"
    print(f"commit {commit()}; OpenCV {cv2.__version__}; from {start}; methods {', '.join(methods)}; data {DATA}")
    for judge in given.judges.split(","):
        JUDGES[judge](options)


if __name__ == "__main__":
    main()
