"""A rig whose lenses were calibrated wrongly, and how far off that is."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import stereorecal as sr
from stereorecal.geometry import changed_camera, view
from stereorecal.recalibration import row_errors_of

TRUE = sr.synthetic.default_rig().resized((320, 240))


def wrong(left: Mapping[str, float], right: Mapping[str, float]) -> sr.StereoRig:
    """Off by these terms, and by focal lengths and rows that nothing but other lenses puts right."""
    off = {"f": 0.002, "cy": 0.7} | dict(left), {"f": -0.003, "cy": -0.5} | dict(right)
    return replace(TRUE, left=changed_camera(TRUE.left, off[0]), right=changed_camera(TRUE.right, off[1]))


def over_the_view(rig: sr.StereoRig) -> float:
    """Root mean square of the rows of points at ten baselines, pixels."""
    apart = row_errors_of(rig, TRUE, view(rig), np.linspace(0, 319, 17), np.linspace(0, 239, 13))[0]
    return float(np.sqrt(np.nanmean(apart**2)))
