"""The rig's own motion as data: windows of two consecutive pairs tell depth, which rows cannot.

As the rig advances, points whose disparity is off move wrongly. Each window is a likelihood of θ; errors that its
tracks have in common make it worse than it believes, how much so all windows say together: where they contradict each
other, or ask for a rig that no calibration leaves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._evidence import Normal, without
from stereorecal.estimation._motion_window import Window, window
from stereorecal.estimation._parameters import DRIFTING
from stereorecal.objectives import RigChart
from stereorecal.scoring import Tracks

# Standard deviations of what windows say, in those that their tracks alone would leave: neighbours err together.
_WORSE = (1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0, 15.0)
_OF_OTHER_THINGS = 0.05  # probability that most of what moves is not the rig
_OWN_YAW = 1.0  # degrees: how far depth seems to be off, then


@dataclass(frozen=True, eq=False)
class Windows:
    """Tracks of some windows of one rig.

    Attributes:
        tracks: of each.
        frames: numbers of the two pairs of each, as correspondences have them; empty where they are not known.
        seconds: from one pair to the other; those of all windows are 1 where times are not known.
    """

    tracks: tuple[Tracks, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    seconds: tuple[float, ...] = ()

    def numbered(self, kept: Sequence[int], first: int = 0) -> "Windows":
        """Those of the frames that are kept, which are numbered anew.

        Args:
            kept: numbers of the frames, in their new order.
            first: number of the first of them.
        """
        new = {frame: first + number for number, frame in enumerate(kept)}
        some = [number for number, frames in enumerate(self.frames) if all(frame in new for frame in frames)]
        return Windows(
            tuple(self.tracks[number] for number in some),
            tuple((new[self.frames[number][0]], new[self.frames[number][1]]) for number in some),
            tuple(self.seconds[number] for number in some),
        )

    def near(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> tuple[Window, ...]:
        """What each says, linear near θ."""
        return tuple(window(one, chart, theta) for one in self.tracks)

    def __bool__(self) -> bool:
        return any(len(one) for one in self.tracks)

    def told(
        self, chart: RigChart, theta: Float[np.ndarray, "n"], prior: CalibrationPrior
    ) -> list[tuple[float, Normal]]:
        """What they may tell of θ, near a θ: as `Beams.told`; that, or all but depth."""
        if not self:
            return [(0.0, Normal(np.zeros((chart.dim,) * 2), np.zeros(chart.dim), 0.0))]
        return with_other_things(together([one.normal for one in self.near(chart, theta)], *root_and_mean(prior)))


NO_WINDOWS = Windows()


def windows_of_all(several: Sequence[Windows]) -> Windows:
    """Those of several recordings, whose frames are numbered apart."""
    return Windows(*(sum((getattr(one, name) for one in several), ()) for name in ("tracks", "frames", "seconds")))


def with_other_things(normal: Normal) -> list[tuple[float, Normal]]:
    """What windows tell, or all but depth, each with the logarithm of its probability."""
    return [
        (float(np.log1p(-_OF_OTHER_THINGS)), normal),
        (float(np.log(_OF_OTHER_THINGS)), without_depth(normal)),
    ]


def root_and_mean(prior: CalibrationPrior) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
    """All calibrations and drifts as one normal distribution of θ: a root of its covariance, and its mean."""
    drifts, weights = drift_sizes()
    covariance = np.einsum("m,mik,mjk->ij", prior.weights, prior.roots, prior.roots)
    covariance[: len(DRIFTING), : len(DRIFTING)] += np.diag(weights @ drifts**2)
    return np.linalg.cholesky(covariance + 1e-18 * np.eye(len(covariance))), prior.weights @ prior.means


def together(several: Sequence[Normal], root: Float[np.ndarray, "n n"], mean: Float[np.ndarray, "n"]) -> Normal:
    """The likelihood of all windows, their errors as much larger as the evidence says.

    Args:
        root: of the covariance of what they tell of, before, and
        mean: its mean.
    """
    total, n = reduce(add, several), len(mean)
    counted = [one for one in several if one.a.any()]
    found = []
    for worse in _WORSE:
        scaled = Normal(
            total.a / worse**2, total.b / worse**2, total.c / worse**2 + 2.0 * n * len(counted) * np.log(worse)
        )
        found.append((without(scaled.around(mean), root).c, scaled))
    return min(found, key=lambda one: one[0])[1]


def without_depth(normal: Normal) -> Normal:
    """The same if the depth that all of them see is not that of the rig: with a yaw of its own."""
    n = len(normal.b)
    axis = np.eye(n)[DRIFTING.index("yaw")]
    to = np.column_stack([np.eye(n), axis])
    return without(Normal(to.T @ normal.a @ to, to.T @ normal.b, normal.c), np.array([[_OWN_YAW]]))
