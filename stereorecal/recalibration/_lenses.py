"""What became of intrinsics that were refined, camera by camera, in units of a calibration file."""

from typing import Any

import numpy as np

from stereorecal.geometry import Camera
from stereorecal.report.repair import Lens

_DISTORTION = ("k1", "k2", "p1", "p2", "k3")  # as OpenCV orders them
_CALLED = {"f": "focal length, f", "cx": "centre, cx", "cy": "centre, cy", "aspect": "aspect, fy / fx"}


def lenses_of(solution: Any) -> list[Lens]:
    """One row for each number, if they were taken; else none: then they stay, and are no answer."""
    seen = solution.intrinsics
    if seen is None or not seen.taken:
        return []
    found = []
    for full, wide in zip(seen.names, seen.interval.tolist(), strict=True):
        camera, _, name = full.partition(".")
        if not name:
            continue  # the baseline, which is an axis of the rig
        before, after = (_value(getattr(rig, camera), name) for rig in (solution.initial, solution.candidate))
        half_width = wide / 100.0 * after if name in ("f", "aspect") else wide
        pixels = name in ("f", "cx", "cy")
        unit, digits = ("px", 2) if pixels else ("", 5)
        observed = full not in seen.undetermined
        found.append(Lens(camera, _CALLED.get(name, name), unit, digits, before, after, half_width, observed))
    return found


def _value(camera: Camera, name: str) -> float:
    matrix = np.asarray(camera.matrix)
    of_matrix = {"f": matrix[0, 0], "aspect": matrix[1, 1] / matrix[0, 0], "cx": matrix[0, 2], "cy": matrix[1, 2]}
    if name in of_matrix:
        return float(of_matrix[name])
    index = _DISTORTION.index(name)
    return float(camera.distortion[index]) if index < len(camera.distortion) else 0.0
