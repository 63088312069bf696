"""Depth of a rig by lidar, or by dense truth, in a scene that is stored rectified."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io import load_scene
from stereorecal.recalibration import depth_error
from stereorecal.recordings import Scene
from stereorecal_field.judges._judgement import DEPTH_WORSE, ROWS_WORSE
from stereorecal_field.judges._optics import optics
from stereorecal_field.judges._rows import followed, row_error_px
from stereorecal_field.judges._sgbm import sgbm

BINS = ((10, 20), (20, 30), (25, 35), (30, 60))  # baselines
_AT = 30  # baselines
_MARGIN = 40.0  # pixels of disparity beyond the true ones that are looked for, on either side
_FEWEST = 200  # pixels of a bin, and of a scene
ENCODINGS = ("uint16/256", "npz arr_0 float32")
_MATCHED_WELL = 0.5  # of the pixels with truth


@dataclass(frozen=True)
class DepthByTruth:
    """What a rig makes of a scene whose depth is known.

    Attributes:
        offset_px: median of disparity found less the one that this rig would have to show [px of
            the stored left camera].
        depth_percent: for each of BINS, the median error of depth; positive: too far; NaN where few pixels are.
        corners_px: the same of followed corners on pixels with truth: they are there for rigs that SGBM cannot match.
        sure_px: the offset, or that of the corners where less than half of the pixels with truth are matched.
        focal: of the stored left camera [px].
        truth_pixels: pixels with truth that are matched.
        matched: pixels of the whole view that are matched.
        rows_px: median |row difference| of followed corners.
    """

    offset_px: float
    corners_px: float
    depth_percent: tuple[float, ...]
    sure_px: float
    focal: float
    truth_pixels: int
    matched: int
    rows_px: float

    @property
    def at_30_percent(self) -> float:
        """|Error| of depth at 30 baselines that the offset stands for, to first order."""
        return 100 * _AT * abs(self.sure_px) / self.focal

    def depth_error_percent(self, baselines: float) -> float:
        """Error of depth at a distance that the offset stands for; positive: too far."""
        return depth_error(1.0 + self.sure_px * baselines / self.focal)

    def worse_than(self, other: "DepthByTruth") -> bool:
        """By more than the tolerance, in rows or in depth at 30 baselines."""
        rows_worse = self.rows_px > other.rows_px + ROWS_WORSE
        return rows_worse or self.at_30_percent > other.at_30_percent + DEPTH_WORSE


def depth_by_truth(judged: StereoRig, stored: StereoRig, scene: Scene) -> DepthByTruth:
    """Judge a rig by the first pair of a scene that `scene_with_truth` read.

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
    matched = np.full(len(pixels), np.nan)
    matched[inside] = found[row[inside], column[inside]]
    known = np.isfinite(matched)
    due, matched, baselines_away = due[known], matched[known] - made.at_infinity, depth[known] / baseline
    due = due - made.at_infinity
    ratio = np.where(matched > 0, due / np.where(matched > 0, matched, 1.0), np.inf)
    bins = [ratio[(baselines_away >= low) & (baselines_away < high)] for low, high in BINS]
    offset = float(np.median(matched - due))
    scale = float(stored.left.matrix[0, 0]) / made.focal
    by_corners = scale * corners_offset(judged, stored, scene)
    matched_well = known.mean() > _MATCHED_WELL
    return DepthByTruth(
        offset_px=scale * offset,
        corners_px=by_corners,
        depth_percent=tuple(100 * (float(np.median(some)) - 1) if len(some) >= _FEWEST else np.nan for some in bins),
        sure_px=scale * offset if matched_well else by_corners,
        focal=float(stored.left.matrix[0, 0]),
        truth_pixels=int(known.sum()),
        matched=int(np.isfinite(found).sum()),
        rows_px=row_error_px(judged, stored, scene),
    )


def corners_offset(judged: StereoRig, stored: StereoRig, scene: Scene) -> float:
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


def scene_with_truth(folder: Path) -> Scene:
    """A scene, stored rectified, that carries `info["truth"]`.

    Raises:
        InputError: if there is no truth, or no scene, or it is not stored rectified.
    """
    scene = load_scene(folder, limit=1)
    name = scene.info.get("disparity_gt")
    if not name:
        raise InputError(f"{folder}: calib.json names no disparity_gt; give the file with true disparities.")
    if scene.rig is None or not _is_rectified(scene.rig):
        raise InputError(
            f"{folder}: true disparities need images that are stored rectified: R = I, y = z = 0, no lens."
        )
    truth = true_disparity(folder / str(name), str(scene.info.get("gt_encoding")))
    if truth.shape != scene.pairs[0].left.shape:
        raise InputError(f"{folder / str(name)} is not of the images' size; give one disparity for each pixel.")
    if np.isfinite(truth).sum() < _FEWEST:
        raise InputError(f"{folder / str(name)}: fewer than {_FEWEST} pixels have a true disparity; give more.")
    return replace(scene, info={**scene.info, "truth": truth})


def true_disparity(file: Path, encoding: str) -> Float[np.ndarray, "h w"]:
    """In pixels of the stored left image, NaN where there is none.

    Raises:
        InputError: if the file cannot be read, or the encoding is not known.
    """
    if encoding not in ENCODINGS:
        raise InputError(f"{file}: gt_encoding {encoding!r} is not known; give one of: {', '.join(ENCODINGS)}.")
    if encoding == "uint16/256":
        image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED) if file.is_file() else None
        if image is None or image.ndim != 2:
            raise InputError(f"{file}: no grey image of true disparities; check calib.json's disparity_gt.")
        return np.where(image > 0, image / 256.0, np.nan)
    try:
        disparity = np.load(file)["arr_0"]
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        raise InputError(f"{file}: no true disparities (npz, arr_0); check calib.json's disparity_gt.") from None
    return np.where(np.isfinite(disparity), disparity, np.nan)


def _is_rectified(rig: StereoRig) -> bool:
    lenses = (np.asarray(camera.distortion) for camera in (rig.left, rig.right))
    level = np.allclose(np.asarray(rig.extrinsics)[[0, 1, 2]], 0.0, atol=1e-6)
    side_by_side = np.abs(rig.translation[1:]).max() < 0.01 * float(
        rig.baseline
    )  # KITTI's colour cameras: 3 mm of 54 cm
    return bool(level and side_by_side and not any(np.any(lens) for lens in lenses))


def depth_of(stored: StereoRig, disparity: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """Z = f B / (d + doffs), of a rig that is stored rectified."""
    left, right = np.asarray(stored.left.matrix), np.asarray(stored.right.matrix)
    return left[0, 0] * abs(float(stored.translation[0])) / (disparity + right[0, 2] - left[0, 2])
