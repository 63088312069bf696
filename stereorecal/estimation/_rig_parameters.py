"""The parameters of a rig that are always in the model: extrinsics, the baseline's length, intrinsics of both cameras.

A vector θ holds their changes from a given rig, in the units of people: degrees for angles, percent of the baseline for
y, z and its length, percent for focal lengths and aspects, pixels for principal points, and coefficients as they are.

Lens terms that a calibration did not fit are in the model too: a lens whose radial term does not end at k2, or whose
decentering does not grow as p1 and p2 say, is read wrongly towards the corners, and there a yaw would pay for it.
"""

from dataclasses import replace

from stereorecal.geometry import OF_MATRIX, StereoRig
from stereorecal.objectives import EXTRINSICS, SIDES, Parameters, Reach, RigChart

DRIFTING = EXTRINSICS  # what moves after a calibration; they are the first of θ


def rig_parameters(rig: StereoRig) -> RigChart:
    """The map from θ (n,) to rigs around `rig`, which is θ = 0; the extrinsics come first."""
    lenses = [f"{side}.{name}" for side in SIDES for name in (*OF_MATRIX, *getattr(rig, side).lens.CALIBRATED)]
    every = Parameters(("extrinsics", "baseline", *lenses)).of(rig, Reach())
    return RigChart(rig, tuple(replace(parameter, sigma=1.0) for parameter in every), wide=1.0)
