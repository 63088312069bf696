"""How it is done: match features, verify them by a two-view geometry, adjust the rig."""

from collections.abc import Sequence

import numpy as np
import pycolmap
from jaxtyping import Float

from stereorecal.objectives import StereoImages
from stereorecal.strategies import Objective, Outcome, Status
from stereorecal_colmap._cameras import colmap_camera, colmap_pose, extrinsics_of
from stereorecal_colmap._colmap import Colmap
from stereorecal_colmap._matches import Matches, matched_pixels, pooled
from stereorecal_colmap._rig import adjusted

pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value  # of the whole process: else stderr has every step


def search(how: Colmap, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
    """The matches of all frames, and the pose that fits them; see `Colmap`."""
    images: StereoImages = objective.images  # there, since the core checks `needs`
    left, right = colmap_camera(images.rig.left, 1), colmap_camera(images.rig.right, 2)
    if left is None or right is None:
        return Outcome(start, Status.STALLED, "COLMAP has no camera model for these lenses")
    pixels = []
    for pair in images.pairs:
        if objective.remaining <= 0:
            return Outcome(start, Status.BUDGET)
        pixels.append(matched_pixels(pair))
    return fitted(how, images, (left, right), pooled(pixels), start, seed)


def fitted(
    how: Colmap,
    images: StereoImages,
    cameras: Sequence[pycolmap.Camera],
    matches: Matches,
    start: np.ndarray,
    seed: int,
) -> Outcome:
    """The pose that COLMAP adjusts to the matches, as an outcome."""
    if len(matches) < how.min_matches:
        return Outcome(start, Status.STALLED, f"only {len(matches)} matches; {how.min_matches} are needed")
    pose, verified = _two_view_geometry(cameras, matches, seed)
    if pose is None or len(verified) < how.min_matches:
        return Outcome(start, Status.STALLED, f"{len(matches)} matches, and no two-view geometry that verifies them")
    chart, x = images.chart, float(images.rig.translation[0])
    begin = np.asarray(chart.extrinsics(start), float)
    ends = [adjusted(how, cameras, first, verified) for first in (colmap_pose(begin), pose)]
    best = max(ends, key=lambda end: (end.points, -end.error))
    message = f"{best.points} of {len(matches)} matches are kept as points"
    if best.points < how.min_matches:
        return Outcome(start, Status.STALLED, f"only {message}; {how.min_matches} are needed")
    found = chart.coordinates(extrinsics_of(best.pose, x))
    message = f"{message}, to {best.error:.2f} px{'' if np.abs(found).max() <= 1.0 else ', outside the reach'}"
    return Outcome(np.clip(found, -1.0, 1.0), Status.CONVERGED, message)


def _two_view_geometry(
    cameras: Sequence[pycolmap.Camera], matches: Matches, seed: int
) -> tuple[pycolmap.Rigid3d | None, Matches]:
    """The right camera's pose from the left one, of any length, and the matches that it verifies."""
    options = pycolmap.TwoViewGeometryOptions()
    options.ransac.random_seed = int(seed) % 2**31
    both = np.repeat(np.arange(len(matches), dtype=np.uint32)[:, None], 2, axis=1)
    found = pycolmap.estimate_calibrated_two_view_geometry(
        cameras[0], matches.left, cameras[1], matches.right, both, options
    )
    verified = matches[np.asarray(found.inlier_matches, int).reshape(-1, 2)[:, 0]]
    known = pycolmap.estimate_two_view_geometry_pose(cameras[0], matches.left, cameras[1], matches.right, found)
    return (found.cam2_from_cam1 if known else None), verified
