"""How the rig turns between two consecutive left images: what a late shutter would take for an offset."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from stereorecal.geometry import Camera

_WIDTH = 320  # pixels, at which corners are followed
_CORNERS = 200
_FEWEST = 20
_BESIDE = 10  # pixels, the half width of the windows in which they are followed
_ROUNDS = 5

Small = UInt8[np.ndarray, "h w"]


def small(image: Float[np.ndarray, "h w"]) -> Small:
    """The image as it is kept until the next one comes."""
    height, width = image.shape
    size = (min(width, _WIDTH), round(height * min(width, _WIDTH) / width))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def turn(camera: Camera, before: Small, after: Small) -> Float[np.ndarray, "3"] | None:
    """Rotation vector (3,) [rad] of x(now) = Q x(before) in the camera's frame; None if nothing can be followed.

    Corners are followed (Lucas & Kanade 1981) and the rotation solved for with Cauchy's weights, since what is near
    moves more than that when the rig travels.
    """
    corners = cv2.goodFeaturesToTrack(before, _CORNERS, 0.01, 6)
    if corners is None or len(corners) < _FEWEST or before.shape != after.shape:
        return None
    moved, followed, _ = cv2.calcOpticalFlowPyrLK(before, after, corners, np.zeros_like(corners))
    tracked = followed.reshape(-1) > 0
    if tracked.sum() < _FEWEST:
        return None
    zoom = camera.size[0] / before.shape[1]
    first, second = ((zoom * (points.reshape(-1, 2)[tracked] + 0.5) - 0.5).astype(float) for points in (corners, moved))
    design, wanted = (_on_sphere if camera.lens.WIDE else _on_plane)(camera, first, second)
    if len(wanted) < _FEWEST:
        return None
    weight, found = np.ones_like(wanted), np.zeros(3)
    for _ in range(_ROUNDS):
        found = np.linalg.lstsq(design * weight[:, None] ** 0.5, wanted * weight**0.5, rcond=None)[0]
        residuals = wanted - design @ found
        spread = max(1.4826 * float(np.median(np.abs(residuals))), 1e-5)
        weight = 1.0 / (1.0 + (residuals / spread) ** 2)
    return found


def _on_plane(
    camera: Camera, first: Float[np.ndarray, "k 2"], second: Float[np.ndarray, "k 2"]
) -> tuple[Float[np.ndarray, "e 3"], Float[np.ndarray, "e"]]:
    """How image points of pixels move with a small rotation, and how they moved."""
    first, second = np.asarray(camera.rays(first)), np.asarray(camera.rays(second))
    x, y = first[:, 0], first[:, 1]
    flow = (second - first)[:, :2]
    one, none = np.ones_like(x), np.zeros_like(x)
    # d(x, y) of the ray (x, y, 1) under a small rotation w: (w x ray) projected.
    across = np.stack([-x * y, one + x**2, -y], axis=-1)
    down = np.stack([-(one + y**2), x * y, x + none], axis=-1)
    return np.concatenate([across, down]), flow.T.reshape(-1)


def _on_sphere(
    camera: Camera, first: Float[np.ndarray, "k 2"], second: Float[np.ndarray, "k 2"]
) -> tuple[Float[np.ndarray, "e 3"], Float[np.ndarray, "e"]]:
    """The same of directions: those far off the axis have no image point on a plane, or one that errs far. What lies at
    the edge of the lens' own image does not move with the scene."""
    rays, moved = np.asarray(camera.directions(first)), np.asarray(camera.directions(second))
    around = camera.size[0] / _WIDTH * _BESIDE * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
    directions_around = np.asarray(camera.directions(first[:, None] + around)).sum(axis=1)
    known = np.isfinite(rays + moved + directions_around).all(axis=1)
    rays, flow = rays[known], (moved - rays)[known]
    by_turn = np.cross(np.eye(3)[:, None], rays)  # (axis, k, 3)
    return by_turn.reshape(3, -1).T, flow.reshape(-1)
