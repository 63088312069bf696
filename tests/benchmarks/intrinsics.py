"""What freed intrinsics and ranges are worth, and what they may cost. Prints a table for each part.

    python tests/benchmarks/intrinsics.py [--rigs N] [--only PART,…]

Rendered rigs whose intrinsics are wrong as chessboards leave them (focal length 0.3 %, centre 1.5 px, k1 0.01, k2
0.02: one sigma, each camera by itself); eight scenes. Rows are those of points at ten baselines over the whole view, of
which no correspondence is known; depth is that straight ahead.

Parts: one (all scenes share the extrinsics), each (each has its own), place (eight frames of one place), ranges (one,
with ten ranges of 1 % at 5 to 40 baselines), right (intrinsics that are right), baseline (its length from 100 ranges),
bumblebee2 (real scenes; intrinsics from some, rows of the others).
"""

import argparse
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.geometry import Camera, changed_camera, view, with_unit_baseline
from stereorecal.recalibration._effects import depth_errors, rows_apart
from stereorecal.scoring import host, median_row_error, pyramid
from stereorecal.scoring.host import ranged

BOTH = ("extrinsics", "intrinsics")
KINDS = ("harbour", "coast", "street")
TRUE = sr.synthetic.default_rig()
BUMBLEBEE = ("garden01", "stones01", "sundial01", "chair01")
PARTS = ("one", "each", "place", "ranges", "right", "baseline", "bumblebee2")


def wrong(seed: int) -> sr.StereoRig:
    """The true rig with intrinsics as a chessboard may leave them."""
    draw = np.random.default_rng(seed)

    def camera(given: Camera) -> Camera:
        sigmas = {"f": 0.003, "cx": 1.5, "cy": 1.5, "k1": 0.01, "k2": 0.02}
        return changed_camera(given, {name: sigma * draw.normal() for name, sigma in sigmas.items()})

    return replace(TRUE, left=camera(TRUE.left), right=camera(TRUE.right))


def rows(rig: sr.StereoRig) -> float:
    """Root mean square over the view, pixels."""
    apart = rows_apart(rig, TRUE, view(rig), np.linspace(0, 639, 33), np.linspace(0, 479, 25))[0]
    return float(np.sqrt(np.nanmean(apart**2)))


def scenes(frames: int = 1) -> list[sr.Scene]:
    return [sr.synthetic.render(KINDS[i % 3], 10 + i, frames=frames) for i in range(8)]


def repaired(given: Sequence[sr.Scene], seed: int, rig: sr.StereoRig, part: str) -> Iterator[tuple]:
    """Rows before and after, depth at 10 and 30 baselines, whether the intrinsics were taken, harm."""
    ranges = []
    if part == "ranges":
        pixels, metres = sr.synthetic.ranges(KINDS[0], 10, number=10, draw=seed)
        pair = given[0].pairs[0]
        ranges = [sr.Range(pair, (p[0], p[1]), m) for p, m in zip(pixels.tolist(), metres.tolist(), strict=True)]
    how = "each" if part == "each" else "one"
    found = sr.recalibrate_many([replace(s, rig=rig) for s in given], free=BOTH, extrinsics=how, ranges=ranges)
    for repair in found if how == "each" else found[:1]:
        solution = repair.solution
        assert solution is not None
        assert solution.intrinsics is not None
        depth = depth_errors(solution.candidate, TRUE)
        before, after = rows(rig), rows(solution.rig)
        yield before, rows(solution.candidate), depth[10], depth[30], solution.intrinsics.taken, after > before + 0.02


def rendered(part: str, rigs: int) -> list[str]:
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
    after = taken if len(taken) else values
    return [
        part,
        f"{np.median(values[:, 0]):.2f}",
        f"{np.median(after[:, 1]):.3f} / {after[:, 1].max():.3f}",
        f"{np.median(np.abs(after[:, 2])):.2f} / {np.median(np.abs(after[:, 3])):.2f} %",
        f"{sum(accepted)} of {rigs}",
        f"{int(values[:, 5].sum())} of {len(values)}",
    ]


def baseline(draws: int) -> str:
    """Of the length, from 100 ranges of 1 %."""
    errors, covered = [], []
    for seed in range(max(1, draws // 5)):
        kind = KINDS[seed % 3]
        scene = sr.synthetic.render(kind, 100 + seed)
        for draw in range(5):
            off = 1.0 + 0.01 * np.random.default_rng([seed, draw]).normal()
            rig = TRUE.with_extrinsics(np.concatenate([TRUE.extrinsics[:3], off * TRUE.extrinsics[3:]]))
            pixels, metres = sr.synthetic.ranges(kind, 100 + seed, number=100, draw=draw)
            ranges = [sr.Range(0, (p[0], p[1]), m) for p, m in zip(pixels.tolist(), metres.tolist(), strict=True)]
            found = sr.rescale_baseline(rig, scene.pairs, ranges)
            errors.append(100.0 * (float(found.rig.baseline / TRUE.baseline) - 1.0))
            covered.append(abs(errors[-1]) < found.interval)
    rms = float(np.sqrt(np.mean(np.square(errors))))
    return f"length of the baseline, {len(errors)} draws: rms {rms:.2f} %, covered {100 * np.mean(covered):.0f} %"


def bumblebee2() -> None:
    """Intrinsics from some scenes of the camera, rows and end points of the others."""
    folder = os.environ.get("STEREORECAL_DATA")
    if folder is None:
        print("bumblebee2: set STEREORECAL_DATA")
        return
    given = [sr.io.load_scene(Path(folder) / "boofcv_bumblebee2" / name) for name in BUMBLEBEE]
    table = Table("intrinsics from", "rows of", "given px", "refined px", "intrinsics", box=None)
    before, after = [], []
    for chosen in combinations(range(4), 2):
        found = sr.recalibrate_many([given[i] for i in chosen], free=BOTH)[0].solution
        assert found is not None
        assert found.intrinsics is not None
        for other in sorted(set(range(4)) - set(chosen)):
            scene = given[other]
            assert scene.rig is not None
            lenses = found.candidate
            ends = [
                sr.recalibrate(rig, scene.pairs).candidate
                for rig in (scene.rig, replace(scene.rig, left=lenses.left, right=lenses.right))
            ]
            medians = [seen(rig, scene.pairs) for rig in ends]
            before.append(medians[0])
            after.append(medians[1])
            names = " ".join(BUMBLEBEE[i] for i in chosen)
            table.add_row(names, scene.name, *(f"{m:.3f}" for m in medians), found.intrinsics.outcome.name)
    Console(width=120).print(table)
    print(f"rows of the others: given median {np.median(before):.3f}, worst {max(before):.3f} px")
    print(f"rows of the others: refined median {np.median(after):.3f}, worst {max(after):.3f} px")
    rest = []
    for left_out in range(4):
        others = [given[i] for i in range(4) if i != left_out]
        found = sr.recalibrate_many(others, free=BOTH)[0].solution
        assert found is not None
        scene = given[left_out]
        assert scene.rig is not None
        lenses = replace(scene.rig, left=found.candidate.left, right=found.candidate.right)
        ends = [np.asarray(sr.recalibrate(rig, scene.pairs).candidate.extrinsics) for rig in (scene.rig, lenses)]
        rest.append([[*np.degrees(e[:3]), *(100 * e[4:] / abs(e[3]))] for e in ends])
    scatter = np.std(np.array(rest), axis=0, ddof=1)
    print(
        "scatter of pitch, yaw, roll [deg], y, z [%]: given",
        np.round(scatter[0], 4),
        "refined",
        np.round(scatter[1], 4),
    )


def seen(rig: sr.StereoRig, pairs: Sequence[sr.Pair]) -> float:
    """Median |row difference| of the correspondences under a rig."""
    images = pyramid(rig, pairs)
    extrinsics = with_unit_baseline(rig.extrinsics)
    return median_row_error(host.correspondences(images.at(1.0), extrinsics, ranged(None, images)), extrinsics)


def main() -> None:
    """Run the parts, print their tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--only", default=",".join(PARTS), help="parts, comma separated")
    options = parser.parse_args()
    parts = [part for part in PARTS if part in options.only.split(",")]
    heads = ("part", "rows given", "refined, median / worst", "|depth| at 10 / 30 B, median", "taken", "harmful")
    table = Table(*heads, box=None)
    for part in parts:
        if part in ("one", "each", "place", "ranges", "right"):
            table.add_row(*rendered(part, options.rigs))
    if table.row_count:
        Console(width=140).print(table)
    if "baseline" in parts:
        print(baseline(10 * options.rigs))
    if "bumblebee2" in parts:
        bumblebee2()


if __name__ == "__main__":
    main()
