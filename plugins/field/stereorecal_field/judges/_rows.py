"""Rows of a rig by corners that are followed from the left image to the right one."""

from functools import lru_cache

import cv2
import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recordings import Pair, Scene
from stereorecal_field.judges._optics import Pixels, optics
from stereorecal_field.judges._sgbm import sgbm

_NEAREST = 0.25  # of the width: disparities that are looked for
_WINDOW = (15, 15)  # pixels
_UNTIL = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-4)  # steps, pixels
_RETURN = 0.2  # pixels between a corner and where it comes back to
_MOST_ROWS, _MOST_ALONG = 8.0, 2.0  # pixels from the stored rig's row, and from SGBM's disparity


def row_error_px(judged: StereoRig, stored: StereoRig, scene: Scene) -> float:
    """Median |row difference| of the followed corners of a scene [px of the stored left camera]. They are followed
    once, in images that the stored rig rectifies, and taken back to raw pixels: every rig is judged by the same
    ones."""
    differences = np.concatenate([row_differences(judged, stored, *followed(stored, pair)) for pair in scene.pairs])
    return float(np.median(np.abs(differences)))


def row_differences(judged: StereoRig, stored: StereoRig, left: Pixels, right: Pixels) -> np.ndarray:
    """Row of left less row of right raw pixels (n, 2), rectified by a rig, at the focal length of the stored one."""
    made = optics(judged)
    return (made.left(left)[:, 1] - made.right(right)[:, 1]) * float(stored.left.matrix[0, 0]) / made.focal


@lru_cache(maxsize=64)
def followed(rig: StereoRig, pair: Pair) -> tuple[Pixels, Pixels]:
    """Corners of a pair and where they are found in the right image, raw pixels (n, 2) each.

    Begun at SGBM's disparity, followed down a pyramid by Lucas-Kanade to parts of a pixel, and back.
    """
    made = optics(rig)
    images = made.images(pair)
    disparity = sgbm(images, -16, _NEAREST * images[0].shape[1])
    corners = cv2.goodFeaturesToTrack(images[0], 6000, 0.003, 5).reshape(-1, 2)
    disparity_guess = disparity[tuple(np.rint(corners[:, ::-1]).astype(int).T)]
    corners, disparity_guess = corners[np.isfinite(disparity_guess)], disparity_guess[np.isfinite(disparity_guess)]
    guess = (corners - np.column_stack([disparity_guess, 0 * disparity_guess])).astype(np.float32)
    found, forward_ok = _flow(images[0], images[1], corners, guess)
    back, backward_ok = _flow(images[1], images[0], found, corners)
    good = (forward_ok.ravel() > 0) & (backward_ok.ravel() > 0) & (np.linalg.norm(back - corners, axis=1) < _RETURN)
    good &= np.abs(corners[:, 0] - found[:, 0] - disparity_guess) < _MOST_ALONG
    good &= np.abs(corners[:, 1] - found[:, 1]) < _MOST_ROWS
    return made.raw(corners[good].astype(float), found[good].astype(float))


def _flow(image, other, points, guess):
    """Where windows around points (n, 1, 2) of an image lie in another one, begun at a guess, and whether they do."""
    how = {"winSize": _WINDOW, "criteria": _UNTIL, "flags": cv2.OPTFLOW_USE_INITIAL_FLOW}
    found, found_ok, _ = cv2.calcOpticalFlowPyrLK(image, other, points, guess.copy(), maxLevel=1, **how)
    return found, found_ok
