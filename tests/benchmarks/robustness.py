"""Does `recalibrate` ever harm, whatever happens to the images or to the intrinsics? Prints one table.

    python tests/benchmarks/robustness.py [--draws N] [--only NAME,…]

Each scene is spoiled in one way at a time and repaired from starts far away and from healthy ones. The SIFT matches
that judge come from the clean images: a repair is harmful if it leaves them more than 0.02 px farther from their rows
than the calibration that it replaces.
"""

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import jax
import numpy as np
from accuracy import median_row_offset, sift_rays
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.recordings import Scene

Images = tuple[np.ndarray, np.ndarray]
REAL = ("boofcv_bumblebee2/garden01", "middlebury2014/motorcycle_quarter")
STARTS = {"2.5°": (2.5, 0.0225), "0.3°": (0.3, 0.003), "0.05°": (0.05, 0.0005), "none": (0.0, 0.0)}


def exposure(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """The right camera is two thirds of a stop darker, with another gamma."""
    return left, 255.0 * (right / 255.0) ** 1.15 * 0.65


def vignetting(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """The corners of the left image have lost 60 % of their light, those of the right one 30 %."""
    height, width = left.shape
    y, x = np.mgrid[:height, :width]
    r2 = ((x / width - 0.5) ** 2 + (y / height - 0.5) ** 2) / 0.5
    return left * (1.0 - 0.6 * r2), right * (1.0 - 0.3 * r2)


def blur(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """The right camera is out of focus."""
    return left, cv2.GaussianBlur(right, (0, 0), 1.5)


def shake(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """Both cameras moved upwards during the exposure."""
    left, right = (cv2.blur(image, (1, 9)) for image in (left, right))
    return left, right


def noise(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """A dark night: 12 grey levels of noise."""
    left, right = (image + draw.normal(0.0, 12.0, image.shape) for image in (left, right))
    return left, right


def glints(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """The sun on waves: bright spots over the lower half, elsewhere in each image."""
    height, width = left.shape
    images = []
    for image in (left, right):
        spoiled = image.copy()
        for _ in range(400):
            x, y = draw.integers(0, width), draw.integers(height // 2, height)
            axes = tuple(int(a) for a in draw.integers(1, max(3, width // 80), 2))
            cv2.ellipse(spoiled, (int(x), int(y)), axes, 0.0, 0.0, 360.0, 255.0, -1)
        images.append(spoiled)
    return images[0], images[1]


def unsynchronised(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """The right image was taken later: three things, a fifth of the image together, have moved by up to 3 rows."""
    height, width = left.shape
    spoiled = right.copy()
    for _ in range(3):
        h, w = height // 4, width // 4
        y, x = draw.integers(5, height - h - 5), draw.integers(5, width - w - 5)
        down, along = draw.integers(-3, 4, 2)
        spoiled[y : y + h, x : x + w] = right[y + down : y + down + h, x + along : x + along + w]
    return left, spoiled


def repetition(left: np.ndarray, right: np.ndarray, draw: np.random.Generator) -> Images:
    """A fence of equal bars across the middle third of both images, at one disparity."""
    height, width = left.shape
    bars = 128.0 + 100.0 * np.sign(np.sin(2.0 * np.pi * np.arange(width + 64) / (width / 50)))
    fence = np.s_[height // 3 : 2 * height // 3]
    left, right = left.copy(), right.copy()
    left[fence], right[fence] = bars[:width], bars[10 : width + 10]
    return left, right


IMAGES: dict[str, Callable[[np.ndarray, np.ndarray, np.random.Generator], Images]] = {
    f.__name__: f for f in (exposure, vignetting, blur, shake, noise, glints, unsynchronised, repetition)
}


def _moved(camera: sr.Camera, focal: float = 1.0, x: float = 0.0, y: float = 0.0) -> sr.Camera:
    matrix = np.array(camera.matrix, float)
    matrix[0, 0] *= focal
    matrix[1, 1] *= focal
    matrix[:2, 2] += x, y
    return replace(camera, matrix=matrix)


INTRINSICS = {
    "f +0.5 %": ({"focal": 1.005}, {"focal": 1.005}),
    "f -0.5 % left": ({"focal": 0.995}, {}),
    "centre x +2 left": ({"x": 2.0}, {}),
    "centre y +2 right": ({}, {"y": 2.0}),
    "centres ±2": ({"x": -2.0, "y": 2.0}, {"x": 2.0, "y": -2.0}),
}


def spoiled(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """The scene, spoiled in each way."""
    assert scene.rig is not None
    yield "clean", scene
    for name, spoil in IMAGES.items():
        draw, pairs = np.random.default_rng(0), []
        for pair in scene.pairs:
            images = spoil(np.asarray(pair.left, np.float32), np.asarray(pair.right, np.float32), draw)
            left, right = (np.clip(np.round(image), 0.0, 255.0).astype(np.float32) for image in images)
            pairs.append(sr.Pair(left, right, pair.name))
        yield name, replace(scene, pairs=tuple(pairs))
    for name, (left, right) in INTRINSICS.items():
        rig = replace(scene.rig, left=_moved(scene.rig.left, **left), right=_moved(scene.rig.right, **right))
        yield name, replace(scene, rig=rig)


def scenes() -> Iterator[Scene]:
    """Rendered ones, and two real ones if they are at hand."""
    for kind in ("harbour", "coast", "street", "open-sea"):
        yield sr.synthetic.render(kind, 1)
    if folder := os.environ.get("STEREORECAL_DATA"):
        for name in REAL:
            yield sr.io.load_scene(Path(folder) / name, limit=1)


def main() -> None:
    """Spoil, repair, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--only", default="", help="parts of names of scenes or cases, comma separated")
    options = parser.parse_args()
    wanted = [part for part in options.only.split(",") if part]
    shown = Table(box=None)
    heads = ["scene", "case", *[f"{s}: accepted" for s in STARTS], "rows before", "after", "harmful", "reasons"]
    for head in heads:
        shown.add_column(head, justify="left" if head in ("scene", "case", "reasons") else "right")
    harmful = total = 0
    for scene in scenes():
        clean_rays = sift_rays(scene)
        for case, given in spoiled(scene):
            if wanted and not any(part in f"{scene.name} {case}" for part in wanted):
                continue
            assert given.rig is not None
            accepted, before, after, harms, reasons = dict.fromkeys(STARTS, 0), [], [], [], set()
            rays = sift_rays(given) if case in INTRINSICS else clean_rays
            for name, (degrees, fraction) in STARTS.items():
                for index in range(options.draws if degrees else 1):
                    key = jax.random.fold_in(jax.random.key(1), index)
                    start = sr.synthetic.decalibrate(given.rig, key, degrees, fraction)
                    solution = sr.recalibrate(start, given.pairs, prior="exact")
                    rows = [median_row_offset(r, rays) for r in (start, solution.rig)]
                    accepted[name] += solution.accepted
                    reasons.add(solution.reason.name)
                    before.append(rows[0])
                    after.append(rows[1])
                    harms.append(rows[1] > rows[0] + 0.02)
            harmful, total = harmful + sum(harms), total + len(harms)
            cells = [scene.name, case, *[str(n) for n in accepted.values()]]
            cells += [f"{np.mean(before):.2f}", f"{np.mean(after):.3f}", str(sum(harms)), " ".join(sorted(reasons))]
            print(" | ".join(cells), flush=True)
            shown.add_row(*cells)
    Console(width=200).print(shown)
    print(f"{harmful} harmful of {total}")


if __name__ == "__main__":
    main()
