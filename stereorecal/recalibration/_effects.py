"""What a change of the extrinsics means to a user: errors of depth."""

from collections.abc import Mapping

import numpy as np

from stereorecal.geometry import StereoRig

DISTANCES = (5, 10, 30, 100)  # baselines


def depth_errors(used: StereoRig, better: StereoRig) -> Mapping[int, float]:
    """By how many percent the depth is wrong that `used` reports, if `better` is right, at some distances.

    For a point straight ahead of the rig at 5, 10, 30 and 100 baselines: projected into both cameras through `better`,
    triangulated through `used` (the nearest point to both rays, on the left one). Positive: reported too far. Infinite
    where the rays of `used` do not meet in front of the cameras.
    """
    return {distance: _depth_error(used, better, distance * float(better.baseline)) for distance in DISTANCES}


def _depth_error(used: StereoRig, better: StereoRig, depth: float) -> float:
    ray = np.array([0.0, 0.0, 1.0])
    from_right = better.rotation @ (depth * ray) + better.translation
    # depth * R ray + T is parallel to what the right camera sees: least squares for the two lengths.
    sides = np.stack([used.rotation @ ray, -from_right / np.linalg.norm(from_right)], axis=-1)
    found, _ = np.linalg.lstsq(sides, -np.asarray(used.translation), rcond=None)[0]
    return float(100.0 * (found / depth - 1.0)) if found > 0 else float("inf")
