"""A rig by how far it travelled: points whose depth two images of the left camera tell, with the distance between them
known, against the disparities that the rig gives them."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.recalibration import depth_error
from stereorecal.recordings import Pair
from stereorecal_field.judges._optics import Pixels, optics
from stereorecal_field.judges._rows import followed

_STEP = 1.5  # baselines travelled, at least, between two images
_WINDOW, _LEVELS = (15, 15), 4  # pixels, of a pyramid
_UNTIL = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-4)
_RETURN, _FIT = 0.2, 0.5  # pixels: between a corner and where it comes back to; of the epipolar error
_PARALLAX = 0.02  # radians between the rays of a point
_FARTHEST = 60.0  # baselines
_FEWEST = 100  # points


@dataclass(frozen=True, eq=False)
class Travelled:
    """Points of all steps: raw pixels (n, 2) in the left and the right image, and depths (n,) along the left axis [m].

    Attributes:
        steps: how many there were.
    """

    left: Pixels
    right: Pixels
    depth: Float[np.ndarray, "n"]
    steps: int


def travelled(rig: StereoRig, pairs: Sequence[Pair], centres: Float[np.ndarray, "k 3"]) -> Travelled:
    """The points of a drive, by the left camera's own intrinsics and where it stood [m].

    Rotations and the direction of each step come from the images; of the poses nothing counts but how far it is.

    Raises:
        InputError: if too few points are found.
    """
    found, first = [], 0
    for last in range(1, len(pairs)):
        step = float(np.linalg.norm(centres[last] - centres[first]))
        if step >= _STEP * float(rig.baseline):
            found.append(_triangulated(rig, pairs[first], pairs[last], step))
            first = last
    left, right, depth = (
        (np.concatenate(part) for part in zip(*found, strict=True))
        if found
        else (np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    )
    if len(depth) < _FEWEST:
        raise InputError(
            f"{len(depth)} points have a depth by the distance travelled, {_FEWEST} are needed; give poses in metres "
            f"of a drive of {_STEP:g} baselines and more."
        )
    return Travelled(left, right, depth, len(found))


def disparity_offset_px(judged: StereoRig, stored: StereoRig, points: Travelled) -> float:
    """Median disparity of the points less the one that the rig would have to show [px of the stored left camera]."""
    made = optics(judged)
    due = made.focal_baseline / made.rectified_depth(points.left, points.depth) + made.at_infinity
    offset = float(np.median(made.left(points.left)[:, 0] - made.right(points.right)[:, 0] - due))
    return offset * float(stored.left.matrix[0, 0]) / made.focal


def depth_at(offset: float, stored: StereoRig, baselines: float) -> float:
    """The error of depth in percent that an offset of disparity stands for, at a distance."""
    return depth_error(1.0 + offset * baselines / float(stored.left.matrix[0, 0]))


def _triangulated(
    rig: StereoRig, pair: Pair, later: Pair, step: float
) -> tuple[Pixels, Pixels, Float[np.ndarray, "n"]]:
    """Corners with a partner in the right image, and their depths by where a later left image has them."""
    left, right = followed(rig, pair)
    moved, good = _tracked(pair.left, later.left, left)
    left, right, moved = left[good], right[good], moved[good]
    rays, later_rays = (_rays(rig.left, pixels) for pixels in (left, moved))
    if len(left) < _FEWEST:
        return left[:0], right[:0], np.zeros(0)
    # As pixels of a pinhole camera: MAGSAC's scale of noise is made for pixels.
    focal = float(rig.left.matrix[0, 0])
    pinhole, first, second = np.diag([focal, focal, 1.0]), focal * rays, focal * later_rays
    essential, agree = cv2.findEssentialMat(first, second, pinhole, method=cv2.USAC_MAGSAC, prob=0.9999, threshold=_FIT)
    if essential is None or essential.shape != (3, 3):
        return left[:0], right[:0], np.zeros(0)
    _, turn, direction, ahead = cv2.recoverPose(essential, rays, later_rays, np.eye(3), mask=agree.copy())
    a, b = (np.column_stack([r, np.ones(len(r))]) for r in (rays, later_rays))
    turned_rays = a @ turn.T
    # depth a: z (R a) + t lies along b, by least squares of the cross product.
    cross, shift = np.cross(b, turned_rays), np.cross(b, step * direction.ravel())
    depth = -(cross * shift).sum(axis=1) / np.maximum((cross**2).sum(axis=1), 1e-18)
    norms = np.linalg.norm(b, axis=1) * np.linalg.norm(turned_rays, axis=1)
    parallax = np.linalg.norm(cross, axis=1) / norms
    good = (agree.ravel() > 0) & (ahead.ravel() > 0) & (parallax > _PARALLAX)
    good &= (depth > 0) & (depth < _FARTHEST * float(rig.baseline))
    return left[good], right[good], depth[good]


def _tracked(image: np.ndarray, later: np.ndarray, pixels: Pixels) -> tuple[Pixels, Bool[np.ndarray, "n"]]:
    """Where corners are in a later image, and whether they come back."""
    first, second = (np.clip(np.rint(one), 0, 255).astype(np.uint8) for one in (image, later))
    start = pixels.astype(np.float32).reshape(-1, 1, 2)
    if not len(start):
        return pixels, np.zeros(0, bool)
    found, forward_ok = _flow(first, second, start)
    back, backward_ok = _flow(second, first, found)
    good = (forward_ok.ravel() > 0) & (backward_ok.ravel() > 0)
    good &= np.linalg.norm(back - start, axis=-1).ravel() < _RETURN
    return found.reshape(-1, 2).astype(float), good


def _flow(image, other, points):
    """Where windows around points (n, 1, 2) of an image lie in another one, and whether they do."""
    found, found_ok, _ = cv2.calcOpticalFlowPyrLK(
        image, other, points, points.copy(), winSize=_WINDOW, maxLevel=_LEVELS, criteria=_UNTIL
    )
    return found, found_ok


def _rays(camera: Camera, pixels: Pixels) -> Pixels:
    """Directions at depth 1."""
    return np.asarray(camera.rays(pixels), float)[:, :2]
