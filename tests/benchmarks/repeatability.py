"""Is the dense way steadier, and nearer to the truth, than SIFT matches and an essential matrix? Prints one table.

    python tests/benchmarks/repeatability.py

Three figures, each for `recalibrate` and for the plug-in `features`, both started from the same calibration:

    frames: standard deviation over the frames of a sequence, each repaired alone
    tiles: standard deviation over bootstrap samples of the image tiles of one pair; correspondences and matches are
        those of the whole images, and each sample is solved anew
    error: median |error| over starts of up to 2.5° and 2.25 % of the baseline away, where the truth is known
"""

from dataclasses import replace

import jax
import numpy as np
from accuracy import AXES, errors, scenes
from real_scenes import real
from stereorecal_features import Features
from stereorecal_features._fit import fitted
from stereorecal_features._matches import matched_pixels, seen_by_both
from tables import show, table_of

import stereorecal as sr
from stereorecal.estimation import rows_of_groups
from stereorecal.recalibration import Case
from stereorecal.recordings import Scene
from stereorecal.scoring import TILES, pyramid

SEQUENCES = {"kitti_odometry/suburb_seq": 8, "euroc/vicon_room_seq": 7}
KNOWN = ("harbour", "coast", "street", "motorcycle_quarter")
BY_FEATURES = sr.Schedule.count(Features(), scale=1.0)
_ROUNDS, _SAMPLES, _DRAWS = 3, 50, 10


def both_ways(start: sr.StereoRig, pairs, reference: sr.StereoRig) -> list[np.ndarray]:
    """(5,) errors of a repair, dense and by features."""
    return [
        errors(sr.recalibrate(start, pairs, schedule=s, prior="exact").candidate, reference)
        for s in (None, BY_FEATURES)
    ]


def over_frames(scene: Scene) -> list[np.ndarray]:
    """(5,) standard deviations, dense and by features."""
    return list(np.std([both_ways(scene.rig, [pair], scene.rig) for pair in scene.pairs], axis=0, ddof=1))


def against_truth(scene: Scene) -> list[np.ndarray]:
    """(5,) median |errors|, dense and by features."""
    keys = [jax.random.fold_in(jax.random.key(1), draw) for draw in range(_DRAWS)]
    starts = [sr.synthetic.decalibrate(scene.rig, key, 2.5, 0.0225) for key in keys]
    return list(np.median(np.abs([both_ways(start, scene.pairs, scene.rig) for start in starts]), axis=0))


def over_tiles(scene: Scene) -> list[np.ndarray]:
    """(5,) standard deviations, dense and by features, of one pair."""
    pair = scene.pairs[0]
    dense, draw = dense_solver(scene.rig, pair), np.random.default_rng(0)
    by_features = features_solver(scene.rig, pair)
    tiles, ends = TILES[0] * TILES[1], []
    for _ in range(_SAMPLES):
        times = np.bincount(draw.integers(0, tiles, tiles), minlength=tiles)
        ends.append([errors(solve(times), scene.rig) for solve in (dense, by_features)])
    return list(np.std(ends, axis=0, ddof=1))


def dense_solver(rig: sr.StereoRig, pair: sr.Pair):
    """times -> rig: the last correspondences of `recalibrate`, each as often as its tile was drawn."""
    solution = sr.recalibrate(rig, [pair], prior="exact")
    settings = solution.settings
    chart = Case(pyramid(rig, [pair], solution.view), settings, solution.matcher, settings.free).chart
    last = solution.stages[-1]
    found = last.found
    assert found is not None

    def solve(times):
        sample = replace(found, weight=np.asarray(found.weight) * times[np.asarray(found.tile)])
        best = chart.coordinates_of(last.ended)
        for _ in range(_ROUNDS):
            best = rows_of_groups(sample, chart, best).residuals(best, chart.prior).least
        return chart.rig_at(best)

    return solve


def features_solver(rig: sr.StereoRig, pair: sr.Pair):
    """times -> rig: the SIFT matches, each as often as its tile was drawn."""
    how = Features()
    images = sr.objective(rig, [pair]).images
    assert images is not None
    pixels = matched_pixels(images.pairs[0].left, images.pairs[0].right, how.features, how.contrast, how.ratio)
    columns, rows = np.floor(pixels[0] / rig.left.size * TILES).astype(int).T
    tile = rows * TILES[0] + columns

    def solve(times):
        chosen = np.repeat(np.arange(len(tile)), times[tile])
        left, right = seen_by_both(images.rig, [(pixels[0][chosen], pixels[1][chosen])])
        end = fitted(how, images, left, right, np.zeros(images.chart.dim), 0).best
        return rig.with_extrinsics(images.chart.extrinsics(end))

    return solve


def main() -> None:
    """Print two lines for each scene and figure."""
    shown = table_of(
        f"scene | figure | way | {' | '.join(AXES)} | steadier on", title="degrees, and percent of the baseline", left=3
    )

    def add(scene, figure, found):
        dense, features = found
        said = f"{np.sum(dense < features)} of 5"
        for way, values in (("dense", dense), ("features", features)):
            shown.add_row(scene.name, figure, way, *[f"{v:.4f}" for v in values], said if way == "dense" else "")
        print(scene.name, figure, "dense", dense.round(4), "features", features.round(4), flush=True)

    for scene in real(SEQUENCES):
        add(scene, "frames", over_frames(scene))
    for scene in scenes():
        if any(name in scene.name for name in KNOWN) and "turned" not in scene.name:
            add(scene, "error", against_truth(scene))
        elif "open-sea" not in scene.name and "turned" not in scene.name:
            add(scene, "tiles", over_tiles(scene))
    show(shown)


if __name__ == "__main__":
    main()
