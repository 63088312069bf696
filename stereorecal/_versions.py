"""What a result was made with."""

import platform
from importlib.metadata import version

import cv2
import jax
import numpy as np


def versions() -> dict[str, str]:
    """Of Python, stereorecal and what its numbers depend on."""
    return {
        "python": platform.python_version(),
        "stereorecal": version("stereorecal"),
        "jax": jax.__version__,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }
