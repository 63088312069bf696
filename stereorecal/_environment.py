"""What a result was made with."""

import platform

import jax
import numpy as np

from stereorecal._cv2 import cv2
from stereorecal._version import __version__


def versions() -> dict[str, str]:
    """Of Python, stereorecal and what its numbers depend on."""
    return {
        "python": platform.python_version(),
        "stereorecal": __version__,
        "jax": jax.__version__,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }
