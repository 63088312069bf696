"""A scene of files that lie anywhere."""

from typing import Any

from stereorecal.io import calibrated_scene, load_pairs
from stereorecal.recordings import Scene


def gathered(left: Any, right: Any, calibration: Any, **options: Any) -> Scene:
    """The scene of image files and a calibration; options as of `calibrated_scene`."""
    return calibrated_scene(str(left), lambda sizes: load_pairs(left, right, sizes=sizes), calibration, **options)
