"""The camera matrix: rounding taken out of it, and what is none refused by its right name."""

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError

_ROUNDING = 1e-6  # of single precision and of six printed digits, in parts of what stands beside


def exact_matrix(matrix: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3 3"]:
    """[[fx 0 cx] [0 fy cy] [0 0 1]]: a finite camera matrix whose zeros and one may be rounded.

    Raises:
        InputError: if it is transposed, of another scale, skewed, singular or negative: says which.
    """
    focal = np.abs(matrix[(0, 1), (0, 1)])
    rest, tolerance = matrix[2] - np.array([0.0, 0.0, 1.0]), _ROUNDING * max(1.0, focal.max())
    if min(matrix[0, 0], matrix[1, 1]) > 0 and not np.any(matrix[:2, 2]) and np.abs(matrix[2, :2]).min() > 1.0:
        raise InputError(
            "the camera matrix is transposed, [[fx 0 0] [0 fy 0] [cx cy 1]], as MATLAB's IntrinsicMatrix; give its "
            "transpose (K.T). If it is MATLAB's, transpose the rotation as well, and subtract 1 from cx and cy, since "
            "MATLAB counts pixels from 1."
        )
    if (
        min(matrix[0, 0], matrix[1, 1]) > 0
        and not np.any(matrix[2, :2])
        and abs(rest[2]) > _ROUNDING
        and matrix[2, 2] > 0
    ):
        raise InputError(
            f"the last number of the camera matrix is {matrix[2, 2]:g}, and must be 1: divide the matrix by it, or "
            "correct the calibration."
        )
    if min(matrix[0, 0], matrix[1, 1]) <= 0 or np.abs(rest).max() > _ROUNDING:
        raise InputError(
            "the camera matrix is singular or negative; it must be [[fx 0 cx] [0 fy cy] [0 0 1]] with positive "
            "focal lengths: correct the calibration."
        )
    if max(abs(matrix[0, 1]), abs(matrix[1, 0])) > tolerance:
        raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
    fx, fy, cx, cy = matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
