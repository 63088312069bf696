"""Rectification as OpenCV's users know it: R1 R2 P1 P2 Q, maps for `cv2.remap`, depth and points."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Num

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError
from stereorecal.geometry._rectification import View, rectifying_rotations, view as view_of
from stereorecal.geometry._rig import StereoRig
from stereorecal.geometry._warp import pixel_map

Projection = Float[np.ndarray, "3 4"]
Plane = Float[np.ndarray, "h w"]


@dataclass(frozen=True, eq=False)
class Rectification:
    """What `cv2.stereoRectify` and `cv2.initUndistortRectifyMap` return, in the units of the rig: metres and pixels.

    Attributes:
        size: (width, height) of the rectified images.
        R1, R2: (3, 3) left and right camera frame to the rectified frame.
        P1, P2: (3, 4) rectified projection matrices; P2[0, 3] is minus the focal length times the baseline.
        Q: (4, 4), takes (column, row, disparity, 1) to homogeneous points in the left rectified frame.
        maps: of the left and the right image, each (map_x, map_y) of (h, w) float32: for
            `cv2.remap(image, *maps[0], cv2.INTER_LINEAR)`. Pixels that no ray of the lens reaches are at (-1, -1).
    """

    size: tuple[int, int]
    R1: Mat3
    R2: Mat3
    P1: Projection
    P2: Projection
    Q: Float[np.ndarray, "4 4"]
    maps: tuple[tuple[Plane, Plane], tuple[Plane, Plane]]

    def depth(self, disparity: Num[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
        """Depth z in the rectified frame [m] of disparities in pixels (x_left - x_right); inf where there is none: at
        infinity, behind it, and NaN stays NaN.

        `cv2.StereoSGBM` and `StereoBM` compute int16 in sixteenths of a pixel: divide by 16.0.

        Raises:
            InputError: if the disparities are integers.
        """
        if np.ndim(disparity) and np.asarray(disparity).dtype.kind in "iu":
            raise InputError(
                f"the disparities are {disparity.dtype}, which cv2's matchers have for sixteenths of a pixel; give "
                "pixels as floating point: disparity / 16.0."
            )
        shift = np.asarray(disparity, float) - (self.P1[0, 2] - self.P2[0, 2])
        with np.errstate(divide="ignore"):
            return np.where(shift > 0.0, -self.P2[0, 3] / shift, np.where(np.isnan(shift), np.nan, np.inf))

    def points(self, disparity: Num[np.ndarray, "h w"]) -> Float[np.ndarray, "h w 3"]:
        """Points (x, y, z) [m] of a disparity image, in the frame of the left camera as it stands on the rig; NaN where
        the disparity is NaN or shows nothing before infinity.

        `cv2.reprojectImageTo3D(disparity, Q)` gives the same points turned by R1.

        Raises:
            InputError: as `depth`, or if the image has another size than the rectified ones.
        """
        if np.shape(disparity) != self.size[::-1]:
            raise InputError(
                f"the disparity image has the shape {np.shape(disparity)}, and the rectified images "
                f"{self.size[::-1]}; give one of that shape."
            )
        z = self.depth(disparity)
        z = np.where(np.isfinite(z), z, np.nan)
        rows, columns = np.indices(np.shape(disparity), float)
        rays = np.stack(
            [
                (columns - self.P1[0, 2]) / self.P1[0, 0],
                (rows - self.P1[1, 2]) / self.P1[1, 1],
                np.ones_like(columns),
            ],
            axis=-1,
        )
        return (rays * z[..., None]) @ np.asarray(self.R1)


def rectification(rig: StereoRig, view: View | None = None) -> Rectification:
    """Everything that OpenCV's users rectify with, in one call.

    Args:
        view: default: `sr.view(rig)`, which has a focal length of its own; `solution.view` for that of a repair.
    """
    view = view_of(rig) if view is None else view
    R1, R2 = (np.asarray(r, float) for r in rectifying_rotations(rig.rotation, rig.translation))
    left, right = (np.asarray(matrix, float) for matrix in (view.matrix_left, view.matrix_right))
    baseline, focal = float(rig.baseline), float(view.focal)
    P1, P2 = (np.column_stack([matrix, np.zeros(3)]) for matrix in (left, right))
    P2[0, 3] = -focal * baseline
    Q = np.eye(4)
    Q[:3, 3] = -left[0, 2], -left[1, 2], focal
    Q[2, 2] = 0.0
    Q[3, 2:] = 1.0 / baseline, -(left[0, 2] - right[0, 2]) / baseline
    planes = [
        np.asarray(pixel_map(camera, rotation, matrix, view.size), np.float32)
        for camera, rotation, matrix in ((rig.left, R1, left), (rig.right, R2, right))
    ]
    maps = ((planes[0][0], planes[0][1]), (planes[1][0], planes[1][1]))
    return Rectification(view.size, R1, R2, P1, P2, Q, maps)
