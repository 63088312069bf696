"""What a strategy gets that works from the images instead of a score."""

from dataclasses import dataclass

from stereorecal.geometry import StereoRig
from stereorecal.objectives._chart import Chart
from stereorecal.recordings import Pair


@dataclass(frozen=True, eq=False)
class Images:
    """The pairs and the calibration at the start.

    Attributes:
        rig: the calibration that the run starts from; its intrinsics are known, its extrinsics are in doubt.
        pairs: the frames, full size, not rectified.
        chart: unit box to extrinsics (radians, metres) and back; the rig's own extrinsics lie at z = 0.
    """

    rig: StereoRig
    pairs: tuple[Pair, ...]
    chart: Chart
