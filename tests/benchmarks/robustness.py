"""Does `recalibrate` ever harm, whatever happens to the images or to the intrinsics? Prints one table.

    python tests/benchmarks/robustness.py [--draws N] [--only NAME,…]

Each scene is spoiled in one way at a time and repaired from starts far away and from healthy ones. The SIFT matches
that judge come from the clean images: a repair is harmful if it leaves them more than 0.02 px farther from their rows
than the calibration that it replaces. (misfit.py spoils images in more ways, and judges them by the true rig.)
"""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import jax
import numpy as np
from accuracy import RENDERED
from real_scenes import real, rig_of
from sift_rows import sift_matches, sift_rows
from spoiled_images import Spoil, blur, crowd, exposure, noise, spoiled, spots
from tables import among, command_line, show, table_of, words

import stereorecal as sr

REAL = ("boofcv_bumblebee2/garden01", "middlebury2014/motorcycle_quarter")
STARTS = {"2.5°": (2.5, 0.0225), "0.3°": (0.3, 0.003), "0.05°": (0.05, 0.0005), "none": (0.0, 0.0)}


def vignetting(left, right, draw):
    """The corners of the left image have lost 60 % of their light, those of the right one 30 %."""
    height, width = left.shape
    y, x = np.mgrid[:height, :width]
    r2 = ((x / width - 0.5) ** 2 + (y / height - 0.5) ** 2) / 0.5
    return left * (1.0 - 0.6 * r2), right * (1.0 - 0.3 * r2)


def shake(left, right, draw):
    """Both cameras moved upwards during the exposure."""
    return cv2.blur(left, (1, 9)), cv2.blur(right, (1, 9))


def fence(left, right, draw):
    """Equal bars across the middle third of both images, at one disparity."""
    height, width = left.shape
    bars = 128.0 + 100.0 * np.sign(np.sin(2.0 * np.pi * np.arange(width + 64) / (width / 50)))
    middle = np.s_[height // 3 : 2 * height // 3]
    left, right = left.copy(), right.copy()
    left[middle], right[middle] = bars[:width], bars[10 : width + 10]
    return left, right


IMAGES: dict[str, Spoil] = {
    "clean": lambda left, right, draw: (left, right),
    "exposure": exposure(0.65, 1.15),
    "vignetting": vignetting,
    "blur": blur(1.5),
    "shake": shake,
    "noise": noise(12),
    "glints": spots(400, 255.0, True),
    "unsynchronised": crowd(3, 1 / 16, 3.0),
    "repetition": fence,
}
INTRINSICS = {  # f as a factor, centre in pixels: of the left camera, and of the right one
    "f +0.5 %": ((1.005, 0, 0), (1.005, 0, 0)),
    "f -0.5 % left": ((0.995, 0, 0), (1, 0, 0)),
    "centre x +2 left": ((1, 2, 0), (1, 0, 0)),
    "centre y +2 right": ((1, 0, 0), (1, 0, 2)),
    "centres ±2": ((1, -2, 2), (1, 2, -2)),
}


def moved(camera: sr.Camera, factor: float, x: float, y: float) -> sr.Camera:
    matrix = np.array(camera.matrix, float) * [[factor, 1, 1], [1, factor, 1], [1, 1, 1]]
    matrix[:2, 2] += x, y
    return replace(camera, matrix=matrix)


def cases(scene: sr.Scene) -> Iterator[tuple[str, sr.Scene]]:
    """The scene, spoiled in each way."""
    for name, spoil in IMAGES.items():
        yield name, spoiled(scene, spoil, name)
    rig = rig_of(scene)
    for name, (left, right) in INTRINSICS.items():
        yield name, replace(scene, rig=replace(rig, left=moved(rig.left, *left), right=moved(rig.right, *right)))


def scenes() -> Iterator[sr.Scene]:
    """Rendered ones, and two real ones if they are at hand."""
    yield from (sr.synthetic.render(kind, 1) for kind in RENDERED)
    yield from real(REAL)


def main() -> None:
    """Spoil, repair, judge, print."""
    parser = command_line(__doc__)
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--only", default="", help="parts of names of scenes or cases, comma separated")
    options = parser.parse_args()
    accepted_from = " | ".join(f"{start}: accepted" for start in STARTS)
    shown = table_of(f"scene | case | reasons | {accepted_from} | rows before | after | harmful", left=3)
    harmful = total = 0
    for scene in scenes():
        wanted = [one for one in cases(scene) if among(f"{scene.name} {one[0]}", words(options.only))]
        matches = sift_matches(rig_of(scene), scene.pairs) if wanted else None
        for case, given in wanted:
            accepted, before, after, reasons = dict.fromkeys(STARTS, 0), [], [], set()
            for name, (degrees, fraction) in STARTS.items():
                for index in range(options.draws if degrees else 1):
                    key = jax.random.fold_in(jax.random.key(1), index)
                    start = sr.synthetic.decalibrate(rig_of(given), key, degrees, fraction)
                    solution = sr.recalibrate(start, given.pairs, prior="exact")
                    accepted[name] += solution.accepted
                    reasons.add(solution.reason.name)
                    before.append(sift_rows(start, matches))
                    after.append(sift_rows(solution.rig, matches))
            harms = int(np.sum(np.array(after) > np.array(before) + 0.02))
            harmful, total = harmful + harms, total + len(before)
            cells = [scene.name, case, " ".join(sorted(reasons)), *map(str, accepted.values())]
            cells += [f"{np.mean(before):.2f}", f"{np.mean(after):.3f}", f"{harms}"]
            print(" | ".join(cells), flush=True)
            shown.add_row(*cells)
    show(shown)
    print(f"{harmful} harmful of {total}")


if __name__ == "__main__":
    main()
