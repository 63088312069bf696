"""How a rig to judge rectifies pixels and images: geometry alone."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from stereorecal import InputError
from stereorecal.geometry import Camera, Rectification, StereoRig, rectification
from stereorecal.recordings import Pair

Pixels = Float[np.ndarray, "n 2"]

_ENOUGH = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-12)


@dataclass(frozen=True, eq=False)
class Optics:
    """A rig and its rectification."""

    rig: StereoRig
    made: Rectification

    @property
    def focal(self) -> float:
        """The focal length of both rectified cameras, in pixels."""
        return float(self.made.P1[0, 0])

    @property
    def focal_baseline(self) -> float:
        """Disparity times depth [px m]."""
        return -float(self.made.P2[0, 3])

    @property
    def at_infinity(self) -> float:
        """Disparity of what is infinitely far away."""
        return float(self.made.P1[0, 2] - self.made.P2[0, 2])

    def images(self, pair: Pair) -> tuple[np.ndarray, np.ndarray]:
        """Both images rectified, 8 bit; black where nothing is seen."""
        grey = (np.clip(np.round(image), 0, 255).astype(np.uint8) for image in (pair.left, pair.right))
        left, right = (cv2.remap(g, *maps, cv2.INTER_CUBIC) for g, maps in zip(grey, self.made.maps, strict=True))
        return left, right

    def left(self, pixels: Pixels) -> Pixels:
        """Raw pixels (n, 2) of the left image, rectified."""
        return _undistorted(pixels, self.rig.left, self.made.R1, self.made.P1)

    def right(self, pixels: Pixels) -> Pixels:
        """Raw pixels (n, 2) of the right image, rectified."""
        return _undistorted(pixels, self.rig.right, self.made.R2, self.made.P2)

    def raw(self, left: Pixels, right: Pixels) -> tuple[Pixels, Pixels]:
        """Where rectified pixels (n, 2) lie in the images as they were taken."""
        made = self.made
        return (
            _distorted(left, self.rig.left, made.R1, made.P1),
            _distorted(right, self.rig.right, made.R2, made.P2),
        )

    def rectified_depth(self, pixels: Pixels, depth: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
        """Depth in the rectified frame of points that this rig's left camera sees at raw pixels, at a depth along its
        own axis."""
        rays = _undistorted(pixels, self.rig.left, np.eye(3), np.eye(3, 4))
        return np.column_stack([rays, np.ones(len(rays))]) @ self.made.R1[2] * depth


def optics(rig: StereoRig) -> Optics:
    """The optics of a rig, in its own view.

    Raises:
        InputError: if its lenses are none that judges of folders know.
    """
    check_lenses(rig)
    return Optics(rig, rectification(rig))


def check_lenses(rig: StereoRig) -> None:
    """Judges of folders work with OpenCV's functions for its pinhole model.

    Raises:
        InputError: if a camera has another model.
    """
    models = [camera.model for camera in (rig.left, rig.right) if camera.model != "radtan"]
    if models:
        raise InputError(
            f"lidar, boards, product and motion=FOLDER judge pinhole cameras (radtan) only, not {models[0]}; no judge "
            "takes wide lenses."
        )


def _undistorted(pixels: Pixels, camera: Camera, turn: ArrayLike, projection: ArrayLike) -> Pixels:
    turn, projection = np.asarray(turn, float), np.asarray(projection, float)
    points = np.ascontiguousarray(pixels, np.float64).reshape(-1, 1, 2)
    lens = np.asarray(camera.distortion, float) if np.size(camera.distortion) else np.zeros(4)
    found = cv2.undistortPoints(points, np.asarray(camera.matrix), lens, None, turn, projection[:, :3], _ENOUGH)
    return found.reshape(-1, 2)


def _distorted(pixels: Pixels, camera: Camera, turn: ArrayLike, projection: ArrayLike) -> Pixels:
    turn, projection = np.asarray(turn, float), np.asarray(projection, float)
    rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(projection[:, :3]).T @ turn
    lens = np.asarray(camera.distortion, float) if np.size(camera.distortion) else np.zeros(4)
    return cv2.projectPoints(rays, np.zeros(3), np.zeros(3), np.asarray(camera.matrix), lens)[0].reshape(-1, 2)
