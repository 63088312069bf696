"""Matrices that calibration files hold beside the calibration (R1, R2, P1, P2, Q, E, F), computed as OpenCV does."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereorecal.geometry import (
    PINHOLE,
    StereoRig,
    rectifying_rotations,
    turn_of,
    turned_pixels,
    turned_size,
    turns_of,
    view as view_shown,
)
from stereorecal.io.formats._numbers import Array, pinhole_matrix

_SAME = 2e-3  # of the focal length: versions of OpenCV differ by less, the options below by more


@dataclass(frozen=True)
class RectifyOptions:
    """The options of `cv2.stereoRectify`, as ROS, KITTI and DepthAI choose them; of lenses that it does not know, the
    two rectified cameras."""

    alpha: float = 0.0  # 0 shows only pixels that are seen, 1 all of them; -1 is OpenCV's choice
    flags: int = cv2.CALIB_ZERO_DISPARITY  # points at infinity have disparity 0
    matrices: tuple[Array, Array] | None = None  # None: those of `sr.view`'s pinhole


def options_of(read: Callable[[], StereoRig], P1: Array, P2: Array, usual: RectifyOptions) -> RectifyOptions:
    """The options with which a file's projection matrices were made from its rig; the usual ones where none fit, as for
    cropped images."""
    if P1[0, 0] <= 0.0:
        return usual
    rig = read()
    if rig.is_wide:
        return replace(usual, matrices=(P1[:, :3], P2[:, :3]))
    for flags in (cv2.CALIB_ZERO_DISPARITY, 0):
        seen, everything = (rectification_of(rig, RectifyOptions(alpha, flags))["P1"][0, 0] for alpha in (0.0, 1.0))
        between = (P1[0, 0] - seen) / (everything - seen) if everything != seen else 0.0
        alphas = dict.fromkeys((usual.alpha, 0.0, 1.0, -1.0, float(np.clip(between, 0.0, 1.0))))
        for alpha in alphas:
            made = rectification_of(rig, RectifyOptions(alpha, flags))
            off = max(np.abs(made[name] - stated)[:, :3].max() for name, stated in (("P1", P1), ("P2", P2)))
            if off <= _SAME * P1[0, 0]:
                return RectifyOptions(alpha, flags)
    return usual


def rectification_of(rig: StereoRig, options: RectifyOptions) -> dict[str, Array]:
    """R1, R2, P1, P2 and Q as `cv2.stereoRectify` computes them; and the regions roi1, roi2 (x, y, width, height) in
    which all pixels are seen."""
    turns = first, second = turns_of(rig.rotation, rig.translation)
    if first != second:  # rectified images are upright
        made = rectification_of(rig.turned(turns), options)
        return made | {"R1": made["R1"] @ turn_of(first), "R2": made["R2"] @ turn_of(second)}
    turned, turn = rig.turned(turns), turn_of(first)
    # OpenCV's own rotations forget turns below 1e-7; some formats have no other place for the extrinsics. Where the
    # right camera is the first one of a file, the baseline lies along x as well, and not against it.
    found = rectifying_rotations(turned.rotation, -_sign(turned) * np.asarray(turned.translation))
    R1, R2 = (turn.T @ np.asarray(rotation) @ turn for rotation in found)
    if rig.is_wide:
        return {"R1": R1, "R2": R2, **_projections(turned, options, first)}
    K1, D1, K2, D2 = (np.asarray(x, float) for one in (rig.left, rig.right) for x in (one.matrix, one.distortion))
    R, T = np.asarray(rig.rotation, float), np.asarray(rig.translation, float).reshape(3, 1)
    _, _, *made = cv2.stereoRectify(K1, D1, K2, D2, rig.left.size, R, T, flags=options.flags, alpha=options.alpha)
    names = ("R1", "R2", "P1", "P2", "Q", "roi1", "roi2")
    return {name: np.asarray(one, float) for name, one in zip(names, (R1, R2, *made), strict=True)}


def _projections(rig: StereoRig, options: RectifyOptions, quarters: int) -> dict[str, Array]:
    """P1, P2, Q and the whole images as regions, of a rig that was turned by so many quarters."""
    ours, (width, height) = view_shown(rig, projection=PINHOLE), turned_size(rig.left.size, quarters)
    left, right = options.matrices or (
        pinhole_matrix(np.array([matrix[0, 0], matrix[1, 1], x, y]))
        for matrix in (np.asarray(ours.matrix_left), np.asarray(ours.matrix_right))
        for x, y in [turned_pixels(matrix[:2, 2], ours.size, -quarters)]
    )
    to_right = turn_of(-quarters) @ [_sign(rig) * float(rig.baseline), 0.0, 0.0]
    axis = quarters % 2
    P1, P2 = (np.column_stack([matrix, np.zeros(3)]) for matrix in (left, right))
    P2[axis, 3] = right[axis, axis] * to_right[axis]
    Q = np.array([[1.0, 0, 0, -left[0, 2]], [0, 1.0, 0, -left[1, 2]], [0, 0, 0, left[0, 0]], [0, 0, 0, 0]])
    Q[3, 2:] = -1.0 / to_right[axis], (left[axis, 2] - right[axis, 2]) / to_right[axis]
    whole = np.array([0.0, 0.0, width, height])
    return {"P1": P1, "P2": P2, "Q": Q, "roi1": whole, "roi2": whole}


def _sign(rig: StereoRig) -> float:
    """The sign of T[0], which is negative unless the first camera is the right one."""
    return 1.0 if rig.translation[0] > 0.0 else -1.0


def epipolar_matrices(rig: StereoRig) -> dict[str, Array]:
    """E = [T]x R; and F, with p_right^T F p_left = 0 and F[2, 2] = 1 where that can be."""
    x, y, z = np.asarray(rig.translation)
    E = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ rig.rotation
    inverse_left, inverse_right = (np.linalg.inv(np.asarray(camera.matrix)) for camera in (rig.left, rig.right))
    F = inverse_right.T @ E @ inverse_left
    return {"E": E, "F": F / F[2, 2] if abs(F[2, 2]) > 1e-12 * np.abs(F).max() else F}
