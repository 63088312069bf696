"""Depth of a rig by lidar, or by dense truth, in a scene that is stored rectified."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from truth_optics import optics, sgbm
from truth_rows import followed, rows

import stereorecal as sr

SCENES = ("kitti2012/000000_10", "kitti2015/000001_10", "middlebury2014/motorcycle_quarter")
BINS = ((10, 20), (20, 30), (25, 35), (30, 60))  # baselines
_AT = 30.0  # baselines
_MARGIN = 40.0  # pixels of disparity beyond the true ones that are looked for, on either side
_FEWEST = 200  # pixels of a bin
_MATCHED_WELL = 0.5  # of the pixels with truth
_ROWS_WORSE, _DEPTH_WORSE = 0.02, 1.0  # px, percentage points


@dataclass(frozen=True)
class DepthByTruth:
    """What a rig makes of a scene whose depth is known.

    Attributes:
        offset_px: median of disparity found less the one that this rig would have to show [px of
            the stored left camera].
        depth_percent: for each of BINS, the median error of depth; positive: too far; NaN where few pixels are.
        corners_px: the same of followed corners on pixels with truth: they are there for rigs that SGBM cannot match.
        at_30_percent: the error of depth at 30 baselines that the offset stands for; that of the corners, where less
            than half of the pixels with truth are matched.
        truth_pixels: pixels with truth that are matched.
        matched: pixels of the whole view that are matched.
        rows_px: median |row difference| of followed corners.
    """

    offset_px: float
    corners_px: float
    depth_percent: tuple[float, ...]
    at_30_percent: float
    truth_pixels: int
    matched: int
    rows_px: float

    def worse_than(self, other: "DepthByTruth") -> bool:
        """By more than the tolerance, in rows or in depth at 30 baselines."""
        rows_worse = self.rows_px > other.rows_px + _ROWS_WORSE
        return rows_worse or self.at_30_percent > other.at_30_percent + _DEPTH_WORSE


def depth_by_truth(judged: sr.StereoRig, stored: sr.StereoRig, scene: sr.Scene) -> DepthByTruth:
    """PixelCounter a rig by the first pair of a scene that `scene_with_truth` read.

    Truth is a depth for pixels of the left image as stored. The judged rig sees each where its own left camera shows
    that pixel, and as far along its own axis.
    """
    truth = scene.info["truth"]
    at = np.argwhere(np.isfinite(truth))
    pixels, baseline = at[:, ::-1].astype(float), abs(float(stored.translation[0]))
    depth = depth_of(stored, truth[tuple(at.T)].astype(float))
    made = optics(judged)
    due = made.focal_baseline / made.rectified_depth(pixels, depth) + made.at_infinity
    found = sgbm(made.images(scene.pairs[0]), -int(_MARGIN), float(np.quantile(due, 0.999)) + _MARGIN)
    height, width = found.shape
    column, row = np.rint(made.left(pixels)).astype(int).T
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    seen = np.full(len(pixels), np.nan)
    seen[inside] = found[row[inside], column[inside]]
    known = np.isfinite(seen)
    due, seen, far = due[known], seen[known] - made.at_infinity, depth[known] / baseline
    due = due - made.at_infinity
    ratio = np.where(seen > 0, due / np.where(seen > 0, seen, 1.0), np.inf)
    bins = [ratio[(far >= low) & (far < high)] for low, high in BINS]
    offset = float(np.median(seen - due))
    scale = float(stored.left.matrix[0, 0]) / made.focal
    by_corners = scale * corners_offset(judged, stored, scene)
    matched_well = known.mean() > _MATCHED_WELL
    return DepthByTruth(
        offset_px=scale * offset,
        corners_px=by_corners,
        depth_percent=tuple(100 * (float(np.median(some)) - 1) if len(some) >= _FEWEST else np.nan for some in bins),
        at_30_percent=100 * _AT * abs(scale * offset if matched_well else by_corners) / (scale * made.focal),
        truth_pixels=int(known.sum()),
        matched=int(np.isfinite(found).sum()),
        rows_px=rows(judged, stored, scene).median_px,
    )


def corners_offset(judged: sr.StereoRig, stored: sr.StereoRig, scene: sr.Scene) -> float:
    """Median disparity of followed corners less the one that a rig would have to show [px of its view]."""
    left, right = followed(stored, scene.pairs[0])
    truth = scene.info["truth"]
    height, width = truth.shape
    column, row = np.rint(left).astype(int).T
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    disparity = np.full(len(left), np.nan)
    disparity[inside] = truth[row[inside], column[inside]]
    known = np.isfinite(disparity)
    left, right, depth = left[known], right[known], depth_of(stored, disparity[known].astype(float))
    made = optics(judged)
    due = made.focal_baseline / made.rectified_depth(left, depth) + made.at_infinity
    return float(np.median(made.left(left)[:, 0] - made.right(right)[:, 0] - due))


def scene_with_truth(folder: Path) -> sr.Scene:
    """A scene that carries `info["truth"]`."""
    scene = sr.io.load_scene(folder)
    return replace(scene, info={**scene.info, "truth": true_disparity(folder)})


def true_disparity(folder: Path) -> np.ndarray:
    """(h, w) in pixels of the stored left image, NaN where there is none."""
    said = json.loads((folder / "calib.json").read_text())
    file, encoding = folder / said["disparity_gt"], said["gt_encoding"]
    if encoding == "uint16/256":
        image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        return np.where(image > 0, image / 256.0, np.nan)
    if encoding == "npz arr_0 float32":
        given = np.load(file)["arr_0"]
        return np.where(np.isfinite(given), given, np.nan)
    raise ValueError(f"{file}: the encoding {encoding!r} is not known")


def depth_of(stored: sr.StereoRig, disparity: np.ndarray) -> np.ndarray:
    """Z = f B / (d + doffs), of a rig that is stored rectified."""
    left, right = np.asarray(stored.left.matrix), np.asarray(stored.right.matrix)
    return left[0, 0] * abs(float(stored.translation[0])) / (disparity + right[0, 2] - left[0, 2])
