"""Rectification for users of OpenCV: R1 R2 P1 P2 Q, maps for `cv2.remap`, depth and points."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Num

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError
from stereorecal.geometry._quarter_turns import turn_of, turned_pixels
from stereorecal.geometry._rig import StereoRig, checked_rig
from stereorecal.geometry._so3 import rectifying_rotations
from stereorecal.geometry._view import PINHOLE, AnyView, View, as_view
from stereorecal.geometry._warp import rectifying_maps

Projection = Float[np.ndarray, "3 4"]
Plane = Float[np.ndarray, "h w"]


@dataclass(frozen=True, eq=False)
class Rectification:
    """The results of `cv2.stereoRectify` and `cv2.initUndistortRectifyMap`, in metres and pixels.

    P1, P2 and Q exist for a pinhole only: in another view depth depends on disparity and column. `depth` and `points`
    work in any view.

    Attributes:
        view: the rectified cameras.
        baseline: of the rig, metres.
        R1, R2: (3, 3) left and right camera frame to the rectified frame.
        maps: of the left and the right image, each (map_x, map_y) of (h, w) float32, for
            `cv2.remap(image, *maps[0], cv2.INTER_LINEAR)`. Pixels that no ray of the lens reaches are at (-1, -1).
    """

    view: View
    baseline: float
    R1: Mat3
    R2: Mat3
    maps: tuple[tuple[Plane, Plane], tuple[Plane, Plane]]

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the rectified images."""
        return self.view.size

    @property
    def P1(self) -> Projection:
        """(3, 4) projection matrix of the left rectified camera."""
        return np.column_stack([self._matrix("P1", self.view.matrix_left), np.zeros(3)])

    @property
    def P2(self) -> Projection:
        """(3, 4) projection matrix of the right rectified camera; P2[0, 3] is minus focal length times baseline."""
        found = np.column_stack([self._matrix("P2", self.view.matrix_right), np.zeros(3)])
        found[0, 3] = -float(self.view.focal) * self.baseline
        return found

    @property
    def Q(self) -> Float[np.ndarray, "4 4"]:
        """(4, 4) matrix that maps (column, row, disparity, 1) to homogeneous points in the left rectified frame."""
        left, found = self._matrix("Q", self.view.matrix_left), np.eye(4)
        found[:3, 3] = -left[0, 2], -left[1, 2], float(self.view.focal)
        found[2, 2] = 0.0
        found[3, 2:] = 1.0 / self.baseline, -float(self.view.at_infinity) / self.baseline
        return found

    def _matrix(self, name: str, matrix: Mat3) -> Float[np.ndarray, "3 3"]:
        if self.view.projection != PINHOLE:
            raise InputError(
                f"{name} is a pinhole's, and this view is {self.view.projection}; use maps, depth and points, or a "
                "pinhole view: sr.view(rig, projection='pinhole')."
            )
        return np.asarray(matrix, float)

    def depth(self, disparity: Num[np.ndarray, "*n"] | Any) -> Float[np.ndarray, "*n"]:
        """Depth z in the rectified frame [m] of disparities in pixels (x_left - x_right); inf for the disparity of
        infinity or beyond; NaN stays NaN.

        `cv2.StereoSGBM` and `StereoBM` compute int16 in sixteenths of a pixel: divide by 16.0.

        Args:
            disparity: an array, for a view other than a pinhole an image; or an `sr.Disparity`, which gives NaN where
                it is not valid.

        Raises:
            InputError: if the disparities are integers, or, for a view other than a pinhole, no image of its size.
        """
        disparity = _checked(disparity)
        if self.view.projection == PINHOLE:
            return self._over(np.asarray(self.view.nearness(np.zeros(()), disparity)))
        distance = self._over(self._nearness(disparity))
        return np.where(np.isinf(distance), np.inf, distance * self._directions()[..., 2])

    def points(self, disparity: Num[np.ndarray, "h w"] | Any) -> Float[np.ndarray, "h w 3"]:
        """Points (x, y, z) [m] of a disparity image, in the frame of the left camera, not rectified; NaN where the
        disparity is NaN, or that of infinity or beyond, and where an `sr.Disparity` is not valid.

        `cv2.reprojectImageTo3D(disparity, Q)` gives the same points turned by R1.

        Raises:
            InputError: if the disparities are integers, or their image has not the size of the view.
        """
        distance = self._over(self._nearness(_checked(disparity)))
        return (self._directions() * np.where(np.isfinite(distance), distance, np.nan)[..., None]) @ np.asarray(self.R1)

    def _over(self, nearness: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
        """Distances [m]: inf where the nearness is 0 or less, NaN where it is NaN."""
        with np.errstate(divide="ignore"):
            return np.where(nearness > 0.0, self.baseline / nearness, np.where(np.isnan(nearness), np.nan, np.inf))

    def _nearness(self, disparity: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "h w"]:
        if disparity.shape != self.size[::-1]:
            raise InputError(
                f"the disparity image has the shape {disparity.shape}, and the rectified images "
                f"{self.size[::-1]}; give one of that shape."
            )
        return np.asarray(self.view.nearness(np.indices(disparity.shape, float)[1], disparity))

    def _directions(self) -> Float[np.ndarray, "h w 3"]:
        rows, columns = np.indices(self.size[::-1], float)
        return np.asarray(self.view.directions(columns, rows, 0))


def _checked(disparity: Any) -> Float[np.ndarray, "*n"]:
    valid = getattr(disparity, "valid", None)  # only a Disparity has it, which is of a package above this one
    if valid is not None:
        return np.where(np.asarray(valid), np.asarray(disparity.values, float), np.nan)
    if np.ndim(disparity) and np.asarray(disparity).dtype.kind in "iu":
        raise InputError(
            f"the disparities are {disparity.dtype}, which cv2's matchers have for sixteenths of a pixel; give "
            "pixels as floating point: disparity / 16.0."
        )
    return np.asarray(disparity, float)


def rectification(rig: StereoRig, view: AnyView = None) -> Rectification:
    """The rectification of a rig: matrices and maps as OpenCV has them.

    Args:
        view: default `sr.view(rig)`, which is no pinhole for wide lenses; `solution.view` is that of a repair; or the
            arguments of `sr.view` by name.
    """
    rig = checked_rig(rig)
    view = as_view(view, rig)
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    R1, R2 = (np.asarray(r, float) @ turn_of(turn) for r, turn in zip(rotations, rig.turns, strict=True))
    found = rectifying_maps(rig.left, rig.right, rotations, view)
    left, right = (
        _of_image_taken(np.asarray(one, np.float32), camera.size, turn)
        for one, camera, turn in zip(found, (rig.left, rig.right), rig.turns, strict=True)
    )
    return Rectification(view, float(rig.baseline), R1, R2, (left, right))


def _of_image_taken(one: Float[np.ndarray, "2 h w"], size: tuple[int, int], turn: int) -> tuple[Plane, Plane]:
    """(map_x, map_y) for the image as it was taken, from the map for the turned image."""
    if turn:
        mapped = (one != -1.0).any(axis=0)
        back = np.moveaxis(turned_pixels(np.moveaxis(one, 0, -1), size, -turn), -1, 0)
        one = np.where(mapped, back, one).astype(np.float32)
    return one[0], one[1]
