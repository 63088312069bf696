"""Grey images from the two messages of a pair."""

from typing import Any

import cv2
import numpy as np

from stereorecal import InputError, StereoRig
from stereorecal.io import image_of_message
from stereorecal_ros._pairing import SIDES


def grey_images(left: Any, right: Any, rig: StereoRig) -> tuple[np.ndarray, np.ndarray]:
    """The two images of a pair, grey, (h, w) of 8 or 16 bit.

    Raises:
        InputError: if one is damaged, encoded in a way that is not known, or of another size than the calibration.
    """
    images = []
    for side, message, camera in zip(SIDES, (left, right), (rig.left, rig.right), strict=True):
        image = image_of_message(message, f"{side}/image_raw")
        if image.ndim == 3:
            image = cv2.cvtColor(image, cv2.COLOR_BGRA2GRAY if image.shape[2] == 4 else cv2.COLOR_BGR2GRAY)
        height, width = image.shape
        if (width, height) != camera.size:
            raise InputError(
                f"{side}/image_raw: the image is {width}x{height}, and the calibration of {camera.size[0]}x"
                f"{camera.size[1]}; publish images of that size."
            )
        images.append(image)
    return images[0], images[1]
