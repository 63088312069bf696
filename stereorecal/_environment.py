"""What a result was made with."""

import platform

from stereorecal._version import __version__


def versions() -> dict[str, str]:
    """Of Python, stereorecal and what its numbers depend on."""
    import jax  # here, since commands have this at hand before they know whether there is work
    import numpy as np

    from stereorecal._cv2 import cv2

    return {
        "python": platform.python_version(),
        "stereorecal": __version__,
        "jax": jax.__version__,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }
