"""The version of this distribution, and what a result was made with."""

import platform

__version__ = "0.1.0"


def versions() -> dict[str, str]:
    """The versions of Python, stereorecal and what its numbers depend on."""
    import cv2  # here, since commands have this at hand before they know whether there is work
    import jax
    import numpy as np

    return {
        "python": platform.python_version(),
        "stereorecal": __version__,
        "jax": jax.__version__,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }
