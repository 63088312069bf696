"""What an epipolar error costs stereo matchers. The rows of the right image of Middlebury's motorcycle are shifted, and
the share of the pixels that each matcher finds, and of those the share that is off by more than 2 px, are printed.

    python tests/benchmarks/matcher_loss.py
"""

from collections.abc import Callable, Iterator

import cv2
import numpy as np
from real_scenes import DATA, present
from tables import show, table_of

import stereorecal as sr
from stereorecal.matching import Disparity

_SCENE = "middlebury2014/motorcycle_quarter"
_SHIFTS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # pixels of row
_WRONG = 2.0  # pixels of disparity
_DISPARITIES = 96


def main() -> None:
    if not present(_SCENE):
        return
    left, right = (cv2.imread(str(DATA / _SCENE / f"{side}.png"), cv2.IMREAD_GRAYSCALE) for side in ("left", "right"))
    truth = np.load(DATA / _SCENE / "disparity_gt.npz")["arr_0"]
    matchers = dict(_matchers())
    heads = [f"{name} {what} %" for name in matchers for what in ("found", "wrong")]
    found = table_of(" | ".join(["rows px", *heads]), title=_SCENE, left=0)
    for shift in _SHIFTS:
        down = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, shift]])
        moved = cv2.warpAffine(right, down, right.shape[::-1], flags=cv2.INTER_CUBIC)
        shares = [share for match in matchers.values() for share in _shares(match(left, moved), truth)]
        found.add_row(f"{shift:.2f}", *(f"{100 * share:.0f}" for share in shares))
    show(found)


def _matchers() -> Iterator[tuple[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]]:
    bm = cv2.StereoBM.create(_DISPARITIES, 15)
    sgbm = cv2.StereoSGBM.create(0, _DISPARITIES, 5, P1=200, P2=800, disp12MaxDiff=1, uniquenessRatio=10)
    sad = sr.SAD(num_disparities=_DISPARITIES)
    yield "sad", lambda left, right: _valid(sad.match(left.astype(np.float32), right.astype(np.float32)))
    yield "StereoBM", lambda left, right: bm.compute(left, right) / 16.0
    yield "StereoSGBM", lambda left, right: sgbm.compute(left, right) / 16.0


def _valid(found: Disparity) -> np.ndarray:
    return np.where(np.asarray(found.valid), np.asarray(found.values), np.nan)


def _shares(disparity: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """The share of the pixels that were found, and the share of those that is wrong."""
    found = np.isfinite(disparity) & (disparity > 0.0)
    known = found & np.isfinite(truth)
    return float(found.mean()), float(np.mean(np.abs(disparity - truth)[known] > _WRONG))


if __name__ == "__main__":
    main()
