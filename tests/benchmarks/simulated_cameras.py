"""True cameras of simulated rigs: what pixels of their images show, raw images or such that were rectified."""

from dataclasses import dataclass

import numpy as np

import stereorecal as sr


def project(camera: sr.Camera, points: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) of points (n, 3); NaN where the camera does not see them or its lens model ends."""
    ahead = np.where(points[:, 2:] > 1e-6, points[:, 2:], np.nan)
    pixels = camera.project(np.column_stack([points[:, :2] / ahead, np.ones(len(points))]))
    radius = np.hypot(points[:, 0], points[:, 1]) / ahead[:, 0]
    seen = (radius < camera.lens_radius) & inside(pixels, camera.size)
    return np.where(seen[:, None], pixels, np.nan)


def rays(camera: sr.Camera, pixels: np.ndarray) -> np.ndarray:
    """Rays (n, 3) at depth 1 of pixels (n, 2); NaN outside of the image and where the lens model ends."""
    known = np.where(inside(pixels, camera.size)[:, None], pixels, np.nan)
    found = np.asarray(camera.rays(known), float)
    radius = np.hypot(found[:, 0], found[:, 1])
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        back = np.abs(camera.project(np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)) - known).max(axis=1)
        return np.where(((radius < camera.lens_radius) & (back < 1e-6))[:, None], found, np.nan)


def inside(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Whether pixels lie in an image; NaN do not."""
    return ((pixels >= 0.0) & (pixels <= np.array(size) - 1.0)).all(axis=1)


@dataclass(frozen=True, eq=False)
class Eye:
    """A true camera, and what was done to its images.

    Attributes:
        lens: the true camera.
        read: as which camera its images were rectified; None: they are raw.
        turn: (3, 3), the camera's frame to that of the images.
        matrix: (3, 3), of the rectified images.
    """

    lens: sr.Camera
    read: sr.Camera | None
    turn: np.ndarray
    matrix: np.ndarray

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Where points (n, 3) in the frame of the images appear in them, (n, 2); NaN where they do not."""
        raw = project(self.lens, points @ self.turn)
        if self.read is None:
            return raw
        turned = rays(self.read, raw) @ self.turn.T
        shown = (turned / turned[:, 2:] @ self.matrix.T)[:, :2]
        return np.where(inside(shown, self.lens.size)[:, None], shown, np.nan)

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """What pixels (n, 2) of the images truly show: rays (n, 3) at depth 1 in the frame of the images, or NaN."""
        if self.read is not None:
            flat = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(self.matrix).T
            pixels = project(self.read, np.where(inside(pixels, self.lens.size)[:, None], flat, np.nan) @ self.turn)
        turned = rays(self.lens, pixels) @ self.turn.T
        return turned / turned[:, 2:]
