"""What is measured besides rows: ranges, and the rig's own motion. Each may be of other things."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._matched_ranges import NO_RANGES, MatchedRanges
from stereorecal.estimation._motion import NO_WINDOWS, Windows
from stereorecal.objectives import RigChart


@dataclass(frozen=True, eq=False)
class Measured:
    """Ranges and windows of what was seen."""

    ranges: MatchedRanges = NO_RANGES
    windows: Windows = NO_WINDOWS

    def likelihoods(
        self, chart: RigChart, theta: Float[np.ndarray, "n"], prior: CalibrationPrior
    ) -> list[tuple[float, Normal]]:
        """What they may tell of θ, near a θ: every combination, each with the logarithm of its probability."""
        of_ranges, of_windows = self.ranges.likelihoods(chart, theta), self.windows.likelihoods(chart, theta, prior)
        return [(one + other, a + b) for (one, a), (other, b) in product(of_ranges, of_windows)]
