"""What calibration files hold beside the calibration, made from it as OpenCV does."""

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig, rectifying_rotations

Array = Float[np.ndarray, "..."]


def rectification_of(rig: StereoRig, alpha: float) -> dict[str, Array]:
    """R1, R2, P1, P2 and Q as `cv2.stereoRectify` computes them, with zero disparity at infinity; and the regions roi1,
    roi2 (x, y, width, height) in which all pixels are seen.

    Args:
        alpha: 0 shows only pixels that are seen, 1 all of them.
    """
    left, right = rig.left, rig.right
    # OpenCV's own rotations forget turns below 1e-7; some formats have no other place for the extrinsics.
    R1, R2 = rectifying_rotations(rig.rotation, rig.translation)
    _, _, P1, P2, Q, roi1, roi2 = cv2.stereoRectify(
        np.asarray(left.matrix, float),
        np.asarray(left.distortion, float),
        np.asarray(right.matrix, float),
        np.asarray(right.distortion, float),
        left.size,
        np.asarray(rig.rotation, float),
        np.asarray(rig.translation, float).reshape(3, 1),
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=alpha,
    )
    regions = (np.array(region, float) for region in (roi1, roi2))
    names = ("R1", "R2", "P1", "P2", "Q", "roi1", "roi2")
    return dict(zip(names, (*map(np.asarray, (R1, R2, P1, P2, Q)), *regions), strict=True))


def essential(rig: StereoRig) -> Array:
    """E = [T]x R."""
    x, y, z = np.asarray(rig.translation)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ rig.rotation


def fundamental(rig: StereoRig) -> Array:
    """F, with p_right^T F p_left = 0 and F[2, 2] = 1 where that can be."""
    inverse_left, inverse_right = (np.linalg.inv(np.asarray(camera.matrix)) for camera in (rig.left, rig.right))
    matrix = inverse_right.T @ essential(rig) @ inverse_left
    return matrix / matrix[2, 2] if abs(matrix[2, 2]) > 1e-12 * np.abs(matrix).max() else matrix
