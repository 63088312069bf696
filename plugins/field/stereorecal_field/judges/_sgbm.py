"""Disparities by which rigs are judged: OpenCV's SGBM, with settings of its own, whatever matcher a method uses.

Paths from all eight sides: with the default five, disparities of roads lag behind by 0.3 px.
"""

import cv2
import numpy as np


def sgbm(images: tuple[np.ndarray, np.ndarray], least: int, most: float) -> np.ndarray:
    """SGBM's disparities (h, w) of rectified 8-bit images, in pixels; NaN where there is none.

    Args:
        least, most: of the disparities that are searched, pixels.
    """
    count = int(np.ceil((most - least) / 16) * 16)
    matcher = cv2.StereoSGBM.create(least, count, 5, 200, 800, 1, 63, 10, 100, 2, cv2.STEREO_SGBM_MODE_HH)
    disparity = matcher.compute(*images).astype(np.float32) / 16.0
    disparity[disparity < least] = np.nan
    return disparity
