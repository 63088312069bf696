"""Are calibrations right, by what no estimate uses: lidar, chessboards, scenes and frames that took no part? Tables.

    python tests/benchmarks/truth.py [--judges lidar,boards,few,sequence,wide] [--method NAME,…] [--from 2.5]
        [--draws N] [--record FOLDER]

Scenes: those of real_scenes.py. Every rig that a method names
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

import subprocess
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import stereorecal_boards
from real_scenes import BUMBLEBEE, CHECKOUT, DATA, present, real, rig_of
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
from tables import command_line, table_of, words
from truth_methods import METHODS
from truth_runs import Judge, Options, Verdicts

import stereorecal as sr

LIDAR = ("kitti2012/000000_10", "kitti2015/000001_10", "middlebury2014/motorcycle_quarter")
BOARDS, CORNERS, SQUARE = "boofcv_bumblebee2/calibration_chess", (4, 6), 0.030  # inner corners; metres
OAK = tuple(
    f"oak_d/{name}"
    for name in ("bedroom_chair", "cycles", "desk", "donkey_toy", "kid_bedroom", "pov_controllers", "selfie", "toy")
)
WIDE = "mynteye_fisheye/hall"
SEQUENCES = {
    "euroc/vicon_room_seq": {"odd": slice(0, None, 2), "even": slice(1, None, 2), "all": slice(None)},
    "kitti_odometry/suburb_seq": {"first": slice(1), "all": slice(None)},
}
SAID = "yaw ° | stated at 30 B % | judged"


def lidar(options: Options) -> None:
    """Depth by truth, a line for each rig."""
    bins = " | ".join(f"{low}-{high} B" for low, high in BINS)
    heads = f"rows px | disparity px | corners px | {bins} | 30 B % | truth px | matched"
    title = "depth by lidar and dense truth"
    verdicts = Verdicts(table_of(f"scene | rig | verdict | {heads} | {SAID}", title=title, left=3))

    def cells(before: DepthByTruth, seen: DepthByTruth) -> list[str]:
        depths = ["-" if np.isnan(error) else f"{error:+.1f}" for error in seen.depth_percent]
        pixels = (f"{seen.rows_px:.3f}", f"{seen.offset_px:+.2f}", f"{seen.corners_px:+.2f}")
        return [*pixels, *depths, f"{seen.at_30_percent:.1f}", f"{seen.truth_pixels}", f"{seen.matched}"]

    for name in filter(present, LIDAR):
        scene = scene_with_truth(DATA / name)
        rig = rig_of(scene)
        stored = depth_by_truth(rig, rig, scene)
        verdicts.table.add_row(name, "stored", "", *cells(stored, stored))
        judge = Judge(
            "lidar",
            ByDepth(rig, scene),
            lambda one, rig=rig, scene=scene: depth_by_truth(one, rig, scene),
            cells,
            lambda before, after: after.worse_than(before),
            lambda before: before.rows_px,
            stored,
        )
        for task in options.tasks(name, [scene]):
            verdicts.judge(options, task, judge)
    verdicts.finish("lidar")


def boards(options: Options) -> None:
    """Chessboards, a line for each rig."""
    if not present(BOARDS, *BUMBLEBEE):
        return
    seen, scenes = find_boards(), [sr.io.load_scene(DATA / name) for name in BUMBLEBEE]
    rig = rig_of(scenes[0])
    stored = by_boards(rig, rig, seen), [row_error_px(rig, rig, scene) for scene in scenes]
    heads = "boards' rows rms px | mean px | squares % | spread % | rows of the scenes px"
    title = f"{len(seen)} chessboards of bumblebee2, at {stored[0].baselines:.1f} baselines"
    verdicts = Verdicts(table_of(f"from | rig | verdict | {heads} | {SAID}", title=title, left=3))

    def cells(before: tuple, after: tuple[ByBoards, list[float]]) -> list[str]:
        found, rows = after
        numbers = (f"{found.rows_rms_px:.3f}", f"{found.rows_mean_px:+.3f}", f"{found.squares_percent:+.2f}")
        return [*numbers, f"{found.squares_spread_percent:.2f}", " ".join(f"{row:.2f}" for row in rows)]

    verdicts.table.add_row("", "stored", "", *cells(stored, stored))
    judge = Judge(
        "boards",
        ByChessboards(rig, seen),
        lambda one: (by_boards(one, rig, seen), [row_error_px(one, rig, scene) for scene in scenes]),
        cells,
        lambda before, after: after[0].worse_than(before[0]),
        lambda before: float(np.median(before[1])),
        stored,
    )
    alone = {name: [scene] for name, scene in zip(BUMBLEBEE, scenes, strict=True)}
    for name, some in (alone | {"all four": scenes}).items():
        for task in options.tasks(name, some):
            verdicts.judge(options, task, judge)
    verdicts.finish("boards")


def few(options: Options) -> None:
    """A line for each rig of a few scenes: rows of these, and of the scenes that took no part."""
    seen = find_boards()
    for of_rig, names, numbers in (("oak_d", OAK, (1, 2, 3, 4)), ("bumblebee2", BUMBLEBEE, (1, 2, 4))):
        if not present(*names):
            continue
        scenes = [sr.io.load_scene(DATA / name) for name in names]
        heads = "own px | unseen: median px | worst growth px | boards px | squares %"
        title = f"few scenes of {of_rig}"
        verdicts = Verdicts(table_of(f"from | rig | verdict | {heads} | {SAID}", title=title, left=3))
        for number in numbers:
            unseen = []
            for first in range(0, len(scenes) - number + 1, number):
                own = list(range(first, first + number))
                rest = [index for index in range(len(scenes)) if index not in own] or own
                judge = by_rows("few", scenes, own, rest, seen if of_rig == "bumblebee2" else None)
                kind = f"{number}: {' '.join(names[index].rpartition('/')[2] for index in own)}"
                for task in options.tasks(kind, [scenes[index] for index in own]):
                    accepted = verdicts.judge(options, task, judge)
                    unseen += [float(np.median(rows[rest])) for rows, _ in accepted]
            if unseen:
                print(f"{of_rig}, by {number}: unseen rows {np.median(unseen):.3f} px, median of those accepted")
        verdicts.finish(f"few scenes of {of_rig}")


def by_rows(bench: str, scenes: list[sr.Scene], own: list[int], rest: list[int], seen: list[Board] | None) -> Judge:
    """Rows of scenes that took part and of others, and boards, if there are any, where no scene took no part."""
    rig = rig_of(scenes[0])

    def measured(one: sr.StereoRig) -> tuple[np.ndarray, ByBoards | None]:
        return np.array([row_error_px(one, rig, scene) for scene in scenes]), seen and by_boards(one, rig, seen)

    def cells(before: tuple, after: tuple) -> list[str]:
        (rows, _), (rows_after, found) = before, after
        medians = [f"{np.median(rows[some]):.3f} -> {np.median(rows_after[some]):.3f}" for some in (own, rest)]
        squares = ("", "")[: 2 * (bench == "few")]
        if found:
            squares = (f"{found.rows_rms_px:.3f}", f"{found.squares_percent:+.3f}")
        return [*medians, f"{(rows_after - rows)[rest].max():+.3f}", *squares]

    def worse(before: tuple, after: tuple) -> bool:
        growth = after[0] - before[0]
        rows_worse = np.median(growth[rest]) > ROWS_WORSE or (bench == "few" and np.mean(growth[own]) > ROWS_WORSE)
        return bool(rows_worse or (after[1] and rest == own and after[1].worse_than(before[1])))

    others = ByCorners.of(rig, [scenes[index] for index in rest])
    return Judge(bench, others, measured, cells, worse, lambda before: float(np.median(before[0])))


def find_boards() -> list[Board]:
    """The chessboards of bumblebee2; none, if they are not there."""
    folder = DATA / BOARDS
    pairs = sr.io.load_pairs(folder / "left*.jpg", folder / "right*.jpg")
    return stereorecal_boards.find_boards(pairs, CORNERS, SQUARE)


def sequence(options: Options) -> None:
    """A line for each rig of some frames of a sequence: rows of these, and of the other frames."""
    heads = f"own px | others: median px | worst growth px | {SAID}"
    verdicts = Verdicts(table_of(f"from | rig | verdict | {heads}", title="frames of a sequence", left=3))
    for whole in real(list(SEQUENCES), None):
        frames = [replace(whole, pairs=(pair,)) for pair in whole.pairs]
        for kind, chosen in SEQUENCES[whole.name].items():
            own = list(range(len(frames)))[chosen]
            rest = [index for index in range(len(frames)) if index not in own] or own
            judge = by_rows("sequence", frames, own, rest, None)
            for task in options.tasks(f"{whole.name} {kind}", [frames[index] for index in own]):
                verdicts.judge(options, task, judge)
    verdicts.finish("sequence")


def wide(options: Options) -> None:
    """A line for each rig of the hall: rows of features that no method looks at."""
    title = "a fisheye, by SIFT"
    verdicts = Verdicts(table_of(f"from | rig | verdict | rows px | {SAID}", title=title, left=3))
    for scene in real([WIDE], None):
        matches = sift_matches(rig_of(scene), scene.pairs)
        judge = Judge(
            "wide",
            BySift(matches),
            lambda rig, matches=matches: sift_rows(rig, matches),
            lambda before, after: [f"{before:.3f} -> {after:.3f}"],
            lambda before, after: after > before + ROWS_WORSE,
            lambda before: before,
        )
        for task in options.tasks(WIDE, [scene]):
            verdicts.judge(options, task, judge)
    verdicts.finish("wide")


def commit() -> str:
    """The commit of the checkout, and whether the library there has changed since."""

    def git(*words: str) -> str:
        return subprocess.run(("git", *words), cwd=CHECKOUT, capture_output=True, text=True, check=False).stdout.strip()

    return git("rev-parse", "--short", "HEAD") + (" and changes" if git("status", "--porcelain", "stereorecal") else "")


JUDGES = {"lidar": lidar, "boards": boards, "few": few, "sequence": sequence, "wide": wide}


def main() -> None:
    """Run methods, judge what they say, print."""
    parser = command_line(__doc__)
    parser.add_argument("--judges", default=",".join(JUDGES), help="comma separated")
    parser.add_argument("--method", default=",".join(METHODS), help="comma separated; none: the stored rigs alone")
    parser.add_argument("--from", dest="degrees", type=float, default=0.0, help="start so many degrees off")
    parser.add_argument("--draws", type=int, default=1, help="starts for each scene, with --from")
    parser.add_argument("--record", type=Path, help="a folder for replay.py")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    options = Options(words(given.method), given.degrees, given.draws, given.record)
    start = f"{given.degrees}° off" if given.degrees else "the stored rigs"
    print(f"commit {commit()}; OpenCV {cv2.__version__}; from {start}; methods {given.method}; data {DATA}")
    for judge in words(given.judges):
        JUDGES[judge](options)


if __name__ == "__main__":
    main()
