"""Rows of a rig by SIFT's matches, which no estimate looks at, through any lens."""

import cv2
import numpy as np

import stereorecal as sr
from stereorecal.geometry import rectifying_rotations

_RATIO, _MOST = 0.75, 3.0  # of distances to the best and the second best; pixels of row


def sift_matches(stored: sr.StereoRig, pair: sr.Pair) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of both images that look alike, near the same row of the stored rig: (n, 2) each."""
    sift = cv2.SIFT.create(6000)
    images = [np.clip(np.asarray(image), 0, 255).astype(np.uint8) for image in (pair.left, pair.right)]
    (a, first), (b, second) = (sift.detectAndCompute(image, None) for image in images)
    pairs = cv2.BFMatcher().knnMatch(first, second, k=2)
    good = [one for one, other in pairs if one.distance < _RATIO * other.distance]
    left, right = (
        np.array([k[i].pt for i in index], float)
        for k, index in ((a, [m.queryIdx for m in good]), (b, [m.trainIdx for m in good]))
    )
    near = np.abs(_differences(stored, left, right)) < _MOST
    return left[near], right[near]


def sift_rows(rig: sr.StereoRig, matches: tuple[np.ndarray, np.ndarray]) -> float:
    """Median |row difference| under a rig, pixels of the left camera's middle."""
    return float(np.nanmedian(np.abs(_differences(rig, *matches))))


def _differences(rig: sr.StereoRig, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Of the angles about the baseline at which both cameras see what matches."""
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    angles = []
    for camera, pixels, rotation in ((rig.left, left, rotations[0]), (rig.right, right, rotations[1])):
        rays = np.asarray(camera.directions(pixels)) @ np.asarray(rotation).T
        angles.append(np.arctan2(rays[:, 1], rays[:, 2]))
    return float(rig.left.focal[0]) * (angles[0] - angles[1])
