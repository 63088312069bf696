"""The images of an objective, for strategies that work on images instead of a score (Need.IMAGES)."""

from dataclasses import dataclass

from stereorecal.geometry import StereoRig
from stereorecal.objectives._chart import Chart
from stereorecal.recordings import Pair


@dataclass(frozen=True, eq=False)
class StereoImages:
    """The pairs and the calibration at the start.

    Attributes:
        rig: the calibration that the run starts from; its intrinsics count as known, its extrinsics have drifted.
        pairs: the frames, full size, not rectified.
        chart: unit box to extrinsics (radians, metres) and back; the rig's own extrinsics lie at z = 0.
    """

    rig: StereoRig
    pairs: tuple[Pair, ...]
    chart: Chart
