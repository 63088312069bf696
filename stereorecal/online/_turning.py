"""How the rig turns between two consecutive left images: what a late shutter would take for an offset."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from stereorecal.geometry import Camera

_WIDTH = 320  # pixels, at which corners are followed
_CORNERS = 200
_FEWEST = 20
_ROUNDS = 5

Small = UInt8[np.ndarray, "h w"]


def small(image: Float[np.ndarray, "h w"]) -> Small:
    """The image as it is kept until the next one comes."""
    height, width = image.shape
    size = (min(width, _WIDTH), round(height * min(width, _WIDTH) / width))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def turn(camera: Camera, before: Small, now: Small) -> Float[np.ndarray, "3"] | None:
    """Rotation vector (3,) [rad] of x(now) = Q x(before) in the camera's frame; None if nothing can be followed.

    Corners are followed (Lucas & Kanade 1981) and the rotation solved for with Cauchy's weights, since what is near
    moves more than that when the rig travels.
    """
    corners = cv2.goodFeaturesToTrack(before, _CORNERS, 0.01, 6)
    if corners is None or len(corners) < _FEWEST or before.shape != now.shape:
        return None
    moved, followed, _ = cv2.calcOpticalFlowPyrLK(before, now, corners, np.zeros_like(corners))
    kept = followed.reshape(-1) > 0
    if kept.sum() < _FEWEST:
        return None
    zoom = camera.size[0] / before.shape[1]
    first, second = (
        np.asarray(camera.rays((zoom * (points.reshape(-1, 2)[kept] + 0.5) - 0.5).astype(float)))
        for points in (corners, moved)
    )
    x, y = first[:, 0], first[:, 1]
    flow = (second - first)[:, :2]
    one, none = np.ones_like(x), np.zeros_like(x)
    # d(x, y) of the ray (x, y, 1) under a small rotation w: (w x ray) projected.
    across = np.stack([-x * y, one + x**2, -y], axis=-1)
    down = np.stack([-(one + y**2), x * y, x + none], axis=-1)
    design, wanted = np.concatenate([across, down]), flow.T.reshape(-1)
    weight, found = np.ones_like(wanted), np.zeros(3)
    for _ in range(_ROUNDS):
        found = np.linalg.lstsq(design * weight[:, None] ** 0.5, wanted * weight**0.5, rcond=None)[0]
        left = wanted - design @ found
        spread = max(1.4826 * float(np.median(np.abs(left))), 1e-5)
        weight = 1.0 / (1.0 + (left / spread) ** 2)
    return found
