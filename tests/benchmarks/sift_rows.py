"""Rows of a rig by SIFT's matches, which no estimate looks at, through any lens."""

import cv2
import numpy as np
from stereorecal_features._matches import matched_pixels

import stereorecal as sr
from stereorecal.geometry import rectifying_rotations

Matches = tuple[np.ndarray, np.ndarray]
_OFF_PLANE = 2.0  # pixels
_FLAT = 4.0  # of rays, x/z and y/z: within 76 degrees of the axis


def sift_matches(rig: sr.StereoRig, pairs: tuple[sr.Pair, ...]) -> Matches:
    """Pixels (n, 2) of features of all pairs that are each other's best match, without any extrinsics' say: an
    essential matrix of their own tells outliers."""
    found, cameras, focal = [np.zeros((2, 0, 2))], (rig.left, rig.right), float(rig.left.focal[0])
    for pair in pairs:
        pixels = np.stack(matched_pixels(pair.left, pair.right, 8000, 0.02, 0.8))
        flat = np.stack([np.asarray(camera.rays(p))[:, :2] for camera, p in zip(cameras, pixels, strict=True)])
        good = (np.linalg.norm(flat, axis=2) < _FLAT).all(axis=0)
        if good.sum() < 5:
            continue
        pinhole = np.diag([focal, focal, 1.0])
        method = {"method": cv2.USAC_MAGSAC, "prob": 0.9999, "threshold": _OFF_PLANE}
        _, inliers = cv2.findEssentialMat(*(focal * flat[:, good]), pinhole, **method)
        if inliers is not None:
            found.append(pixels[:, good][:, inliers.ravel() > 0])
    left, right = np.concatenate(found, axis=1)
    return left, right


def rectified_rays(rig: sr.StereoRig, matches: Matches) -> list[np.ndarray]:
    """What both cameras see of matched pixels, turned to the rows of a rig: unit vectors (n, 3) each."""
    turns = rectifying_rotations(rig.rotation, rig.translation)
    cameras = (rig.left, rig.right)
    return [np.asarray(c.directions(p)) @ t.T for c, p, t in zip(cameras, matches, turns, strict=True)]


def sift_rows(rig: sr.StereoRig, matches: Matches) -> float:
    """Median |difference| of the angles about the baseline at which both cameras see what matches, in pixels of the
    left camera's middle; NaN without matches."""
    if not len(matches[0]):
        return float("nan")
    angles = [np.arctan2(rays[:, 1], rays[:, 2]) for rays in rectified_rays(rig, matches)]
    return float(rig.left.focal[0]) * float(np.nanmedian(np.abs(angles[0] - angles[1])))
