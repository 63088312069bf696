"""How fast, beside OpenCV with the same settings and as many threads? Prints one table, in one run.

    python tests/benchmarks/speed.py [--rounds N] [--part platforms] [--check FILE]

Each figure is timed on both sides in turn, and the medians are compared (repairs and the search: one call each). A
process of its own is bound to as many cores as the threads that are stated; OpenCV is told the same number. Pairs: a
rendered street, 741x500, 80 disparities, window 11, x-Sobel prefilter, uniqueness, texture and left-right check on;
repairs: 640x480; beside them PoseLib, where it is installed.

`--check` keeps the ratios in a file that is not there yet. Where it is, each ratio that is worse by a fifth is measured
again; if it still is, that is a regression, and the exit code is 1. Keep and check on one machine: processors differ.
"""

import ctypes
import json
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import jax
import jax.numpy as jnp
import numpy as np
from processes import first_cores, last_line, memory_mb
from real_scenes import rig_of
from rich.table import Table
from stereorecal_features._matches import matched_pixels
from tables import command_line, show, table_of

import stereorecal as sr
from stereorecal.geometry import bilinear_warp, pixel_map, rectifying_rotations, with_unit_baseline
from stereorecal.objectives import Reach, count_chart
from stereorecal.recordings import Scene
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts
from stereorecal.scoring.host._cores import on_all_cores
from stereorecal.scoring.host._disparities import compiled_rotations, match_in_blocks, rectified_frame
from stereorecal.strategies import Budget, Objective, Problem, run_strategy, strategy

try:
    import poselib  # pyright: ignore[reportMissingImports]
except ImportError:
    poselib = None

MATCHER = sr.SAD(num_disparities=80)
WORSE = 1.2  # times the ratio that was kept: a regression


@dataclass(frozen=True)
class Figure:
    """One line of the table: milliseconds of each side."""

    name: str
    threads: int
    ours: float
    theirs: float | None

    @property
    def ratio(self) -> float | None:
        """The ratio of our time to theirs."""
        return None if self.theirs is None else self.ours / self.theirs

    @property
    def key(self) -> str:
        """By which it is found again."""
        return f"{self.name}, threads: {self.threads}"


def timed(rounds: int, *functions: Callable[[], object]) -> list[float]:
    """Median milliseconds of each, called in turn, after one call each that compiles."""
    for function in functions:
        function()
    spent: list[list[float]] = [[] for _ in functions]
    for _ in range(rounds):
        for function, times in zip(functions, spent, strict=True):
            began = time.perf_counter()
            function()
            times.append(1e3 * (time.perf_counter() - began))
    return [float(np.median(times)) for times in spent]


# --- the other side -----------------------------------------------------------------------------------------


def block_matcher(disparities: int, kind=cv2.StereoBM):
    """OpenCV's, with the settings of `SAD`'s defaults."""
    found = kind.create(numDisparities=-(-disparities // 16) * 16, blockSize=11)
    found.setUniquenessRatio(15)
    found.setDisp12MaxDiff(1)
    if kind is cv2.StereoBM:
        found.setPreFilterType(cv2.STEREO_BM_PREFILTER_XSOBEL)
        found.setPreFilterCap(31)
        found.setTextureThreshold(10)
    return found


def remapped(camera: sr.Camera, image: np.ndarray, turn: np.ndarray, matrix: np.ndarray, size) -> np.ndarray:
    """One image rectified, as OpenCV users do it."""
    maps = cv2.initUndistortRectifyMap(camera.matrix, camera.distortion, turn, matrix, size, cv2.CV_32FC1)
    return cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def both_remapped(rig: sr.StereoRig, images, view, extrinsics: np.ndarray) -> list[np.ndarray]:
    """Both images rectified by `extrinsics`."""
    moved = rig.with_extrinsics(extrinsics)
    rotations = rectifying_rotations(moved.rotation, moved.translation)
    matrices = (np.asarray(view.matrix_left), np.asarray(view.matrix_right))
    sides = zip((rig.left, rig.right), images, rotations, matrices, strict=True)
    return [remapped(*side, view.size) for side in sides]


def spread(threads: int, make: Callable[[], Callable], items: list) -> Callable[[], object]:
    """Each item through a function of its thread's own, OpenCV itself on one thread; or one after the other, and OpenCV
    on all threads: what is faster."""
    workers = [make() for _ in range(threads)]
    pool = ThreadPoolExecutor(threads)

    def apart():
        cv2.setNumThreads(1)
        parts = [items[i::threads] for i in range(threads)]
        return list(pool.map(lambda w, part: [w(item) for item in part], workers, parts))

    def in_turn():
        cv2.setNumThreads(threads)
        return [workers[0](item) for item in items]

    first, second = timed(5, apart, in_turn)
    return apart if first < second else in_turn


def opencv_counter(rig: sr.StereoRig, pair: sr.Pair, view, disparities: int) -> Callable[[np.ndarray], int]:
    """extrinsics -> pixels with a disparity."""
    images, matcher = [np.round(i).astype(np.uint8) for i in (pair.left, pair.right)], block_matcher(disparities)
    return lambda extrinsics: int((matcher.compute(*both_remapped(rig, images, view, extrinsics)) >= 0).sum())


def pose_by_magsac(left: np.ndarray, right: np.ndarray, focal: float) -> object:
    """Rotation and direction of the baseline, by pixels of a pinhole camera."""
    pinhole = np.diag([focal, focal, 1.0])
    essential, inliers = cv2.findEssentialMat(left, right, pinhole, method=cv2.USAC_MAGSAC, prob=0.9999, threshold=1.0)
    return cv2.recoverPose(essential, left, right, pinhole, mask=inliers)


def pose_by_poselib(left: np.ndarray, right: np.ndarray, focal: float) -> object:
    """The same."""
    camera = {"model": "SIMPLE_PINHOLE", "width": 1, "height": 1, "params": [focal, 0.0, 0.0]}
    return poselib.estimate_relative_pose(left, right, camera, camera, {"max_epipolar_error": 1.0}, {})


def by_features(rig: sr.StereoRig, pair: sr.Pair, pose: Callable[[np.ndarray, np.ndarray, float], object]) -> object:
    """SIFT's matches, and the pose that they show."""
    pixels, focal = matched_pixels(pair.left, pair.right, 4096, 0.02, 0.8), float(rig.left.focal[0])
    sides = zip((rig.left, rig.right), pixels, strict=True)
    return pose(*(focal * np.asarray(camera.rays(found))[:, :2] for camera, found in sides), focal)


# --- figures ------------------------------------------------------------------------------------------------


def scene_of(size: tuple[int, int], frames: int = 1) -> Scene:
    """A rendered street."""
    return sr.synthetic.render("street", 0, rig=sr.synthetic.default_rig().resized(size), frames=frames)


def around(rig: sr.StereoRig, number: int) -> np.ndarray:
    """(n, 6) candidates near the truth: no two share a rotation."""
    step = np.random.default_rng(0).uniform(-1, 1, (number, 6)) * [0.003, 0.003, 0.003, 0, 0.003, 0.003]
    return np.asarray(rig.extrinsics) + step * [1, 1, 1, 1, float(rig.baseline), float(rig.baseline)]


def matching(threads: int, rounds: int) -> Iterator[Figure]:
    """SAD against StereoBM and StereoSGBM; where `plugins/native` is installed, its SAD."""
    scene = scene_of((741, 500))
    (frame,) = prepare(scene.rig, scene.pairs, sr.view(scene.rig)).frames
    rectified = rectified_frame(frame, compiled_rotations(with_unit_baseline(scene.rig.extrinsics)))
    images = [np.asarray(side).round().astype(np.uint8) for side in (rectified.left, rectified.right)]
    bm, sgbm = block_matcher(80), block_matcher(80, cv2.StereoSGBM)
    matched = (lambda: match_in_blocks(MATCHER, rectified), lambda: bm.compute(*images), lambda: sgbm.compute(*images))
    ours, theirs, slower = timed(rounds, *matched)
    yield Figure("SAD / StereoBM, one pair", threads, ours, theirs)
    yield Figure("SAD / StereoSGBM, one pair", threads, ours, slower)

    def alone() -> Callable[[list[np.ndarray]], np.ndarray]:
        matcher = block_matcher(80)
        return lambda pair: matcher.compute(*pair)

    def eight() -> list[sr.matching.Disparity]:
        return on_all_cores(lambda one: match_in_blocks(MATCHER, one), [rectified] * 8)

    ours, theirs = timed(rounds, eight, spread(threads, alone, [images] * 8))
    cv2.setNumThreads(threads)
    yield Figure("SAD / StereoBM, eight pairs", threads, ours, theirs)


def warping(threads: int, rounds: int) -> Iterator[Figure]:
    """One warp, maps included."""
    scene = scene_of((741, 500))
    rig, pair = rig_of(scene), scene.pairs[0]
    view, turn = sr.view(rig), rectifying_rotations(rig.rotation, rig.translation)[0]
    matrix, camera = np.asarray(view.matrix_left), rig.left
    image, pixels = jnp.asarray(pair.left), np.round(pair.left).astype(np.uint8)

    @jax.jit
    def warp(image, turn):
        return bilinear_warp(image, jax.lax.optimization_barrier(pixel_map(camera, turn, view, 0)))

    turned = jnp.asarray(turn, jnp.float32)
    ours, theirs = timed(
        rounds,
        lambda: warp(image, turned).block_until_ready(),
        lambda: remapped(camera, pixels, turn, matrix, view.size),
    )
    yield Figure("one warp, maps included / cv2", threads, ours, theirs)


def counting(threads: int, rounds: int) -> Iterator[Figure]:
    """Ten candidates at quarter scale; a search of 500 evaluations at full scale."""
    scene = scene_of((741, 500))
    rig = rig_of(scene)
    view = sr.view(rig)
    quarter = prepare(rig, scene.pairs, view, 0.25)
    size = (quarter.left.shape[2], quarter.left.shape[1])
    resized = rig.resized(size), scene.pairs[0].resized(size), view.scaled(0.25)
    matcher = sr.SAD(num_disparities=128)  # a quarter of it is a number that BM takes
    candidates = around(rig, 10)
    others = spread(threads, lambda: opencv_counter(*resized, 32), list(candidates))
    stacked = np.stack([with_unit_baseline(c) for c in candidates])
    ours, theirs = timed(rounds, lambda: counts(quarter, stacked, matcher), others)
    cv2.setNumThreads(threads)
    name = "10 counts at quarter scale, 32 disparities / OpenCV"
    yield Figure(name, threads, ours, theirs)
    if threads == 2:
        start = sr.synthetic.decalibrate(rig, jax.random.key(0), 1.0, 0.01)
        compass, budget = strategy("compass", min_step=1e-12), Budget(500)
        full = opencv_counter(start, scene.pairs[0], sr.view(start), 80)
        chart = count_chart(start, Reach())

        def by_opencv():
            problem = Problem(chart.dim, lambda z: np.array([full(chart.extrinsics(p)) for p in z], float), 1.0)
            return run_strategy(compass, Objective(problem, budget), np.zeros(chart.dim), 0)

        def by_us():
            asked = sr.objective(start, scene.pairs, matcher=MATCHER, reach=Reach(), budget=budget)
            return run_strategy(compass, asked, np.zeros(chart.dim), 0)

        yield Figure("compass, 500 evaluations, full scale / OpenCV", 2, *timed(1, by_us, by_opencv))


def repairing(threads: int, rounds: int) -> Iterator[Figure]:
    """The default schedule, warm; features and a robust pose, which say nothing of depth or of how sure they are."""
    scene = scene_of((640, 480))
    starts = [sr.synthetic.decalibrate(scene.rig, jax.random.key(k), 2.5, 0.0225) for k in range(8)]
    for start in starts:
        sr.recalibrate(start, scene.pairs)
    times = [timed(1, lambda start=start: sr.recalibrate(start, scene.pairs))[0] for start in starts]
    name, ours, pair = "a default repair, 640x480", float(np.median(times)), scene.pairs[0]
    yield Figure(name, threads, ours, None)
    cv2.setNumThreads(max(threads, 1))
    for other, pose in {"MAGSAC": pose_by_magsac, **({"PoseLib": pose_by_poselib} if poselib else {})}.items():
        theirs = timed(3, lambda pose=pose: by_features(starts[0], pair, pose))[0]
        yield Figure(f"{name} / SIFT and {other}", threads, ours, theirs)


def on_this_platform() -> None:
    """Print the platform, and what it does to many candidates at once and in a repair."""
    scene = scene_of((741, 500))
    full, quarter = (prepare(scene.rig, scene.pairs, sr.view(scene.rig), scale) for scale in (1.0, 0.25))
    stacked = np.stack([with_unit_baseline(c) for c in around(scene.rig, 256)])
    slope = jax.jit(jax.vmap(jax.grad(lambda e: sr.soft_count(quarter, e, MATCHER))))
    few = jnp.asarray(stacked[:32], jnp.float32)

    def per_second(number: int, work: Callable[[], object]) -> float:
        return 1e3 * number / timed(5, work)[0]

    def matched() -> object:
        return jax.block_until_ready(sr.correspondences(full, stacked[0], MATCHER))

    figures = {
        "256 candidates at quarter scale": per_second(256, lambda: counts(quarter, stacked, MATCHER)),
        "64 candidates at full scale": per_second(64, lambda: counts(full, stacked[:64], MATCHER)),
        "32 gradients of the soft count at quarter scale": per_second(32, lambda: slope(few).block_until_ready()),
        "correspondences at full scale": per_second(1, matched),
        "default repairs, 640x480": 1e3 / next(repairing(0, 1)).ours,
    }
    print(json.dumps([jax.default_backend(), figures]))


PARTS = {1: (matching, warping, counting, repairing), 2: (matching, counting, repairing)}


def measured(threads: int, rounds: int) -> list[Figure]:
    """All figures of this process, which is bound to so many cores."""
    cv2.setNumThreads(threads)
    return [figure for part in PARTS[threads] for figure in part(threads, rounds)]


def peak_memory() -> None:
    """Print how many megabytes one evaluation of 1280x720 pixels and 128 disparities adds at its peak."""
    scene = scene_of((1280, 720))
    data = prepare(scene.rig, scene.pairs, sr.view(scene.rig))
    stacked, matcher = with_unit_baseline(scene.rig.extrinsics)[None], sr.SAD(num_disparities=128)
    counts(data, stacked, matcher)  # compiles
    ctypes.CDLL("libc.so.6").malloc_trim(0)  # or what the first call left would count as there before
    before = memory_mb()
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak so far
    counts(data, stacked, matcher)
    print(memory_mb("VmHWM") - before)


def part(name: str, cores: int, rounds: int, **environment: str) -> str:
    """What this program prints last as `--part name`, bound to so many cores."""
    return last_line(__file__, "--part", name, "--rounds", rounds, cores=first_cores(cores), **environment)


def of_each_platform(rounds: int) -> Table:
    """What JAX's own platform and the CPU do in a second, on all cores: once where they are the same."""
    everywhere = len(os.sched_getaffinity(0))
    per_second = dict(json.loads(part("platform", everywhere, rounds, **p)) for p in ({}, {"JAX_PLATFORMS": "cpu"}))
    shown = table_of(" | ".join(["figure", *per_second]), title="in a second")
    for name in next(iter(per_second.values())):
        shown.add_row(name, *(f"{speeds[name]:.3g}" for speeds in per_second.values()))
    return shown


def beside_opencv(figures: list[Figure], megabytes: float) -> Table:
    """The table of what each side takes."""
    shown = table_of(
        "figure | threads | ours, ms | OpenCV, ms | ratio",
        title=f"{os.cpu_count()} cores, OpenCV {cv2.__version__}, JAX {jax.__version__}",
    )
    for f in figures:
        other, ratio = ("", "") if f.ratio is None else (f"{f.theirs:.2f}", f"{f.ratio:.2f}")
        shown.add_row(f.name, f"{f.threads}", f"{f.ours:.2f}", other, ratio)
    shown.add_row("peak memory, 1280x720, 128 disparities", "1", f"{megabytes:.0f} MB", "", "")
    return shown


def figures_of(threads: int, rounds: int) -> list[Figure]:
    """All figures of so many threads, in a process of their own."""
    return [Figure(**figure) for figure in json.loads(part(f"{threads}", threads, rounds))]


def regressions(figures: Sequence[Figure], kept: dict[str, float]) -> dict[str, tuple[float, float]]:
    """The ratios that were kept and are worse by a fifth, or measured no more, and what they are now, by key."""
    now = {figure.key: figure.ratio for figure in figures if figure.ratio is not None}
    return {key: (old, new) for key, old in kept.items() if (new := now.get(key, np.inf)) > WORSE * old}


def checked(figures: Sequence[Figure], file: Path, rounds: int) -> None:
    """Keep the ratios, or compare them with those kept.

    Raises:
        SystemExit: if one is worse twice.
    """
    if not file.exists():
        file.write_text(json.dumps({f.key: f.ratio for f in figures if f.ratio is not None}, indent=2) + "\n")
        return
    kept = json.loads(file.read_text())
    worse = regressions(figures, kept)
    again = [f for threads in {f.threads for f in figures if f.key in worse} for f in figures_of(threads, rounds)]
    twice = regressions(again, {key: kept[key] for key in worse})
    if twice:
        lines = [f"{key}: ratio {before:.2f} -> {after:.2f}" for key, (before, after) in twice.items()]
        raise SystemExit("\n".join(["slower by a fifth, twice:", *lines]))


def main() -> None:
    """Time both sides, in processes of their own."""
    parser = command_line(__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--part", help="platforms: only what JAX's own platform and the CPU do in a second")
    parser.add_argument("--check", type=Path, metavar="FILE", help="keep the ratios there, or compare with those kept")
    options = parser.parse_args()
    if options.part == "memory":
        peak_memory()
    elif options.part == "platform":
        on_this_platform()
    elif options.part == "platforms":
        show(of_each_platform(options.rounds))
    elif options.part:
        print(json.dumps([asdict(f) for f in measured(int(options.part), options.rounds)]))
    else:
        figures = [figure for threads in PARTS for figure in figures_of(threads, options.rounds)]
        show(beside_opencv(figures, float(part("memory", 1, options.rounds))), of_each_platform(options.rounds))
        if options.check is not None:
            checked(figures, options.check, options.rounds)


if __name__ == "__main__":
    main()
