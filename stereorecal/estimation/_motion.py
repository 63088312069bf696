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
from stereorecal.estimation._evidence import Normal, marginal
from stereorecal.estimation._motion_window import Window, far_enough, window
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.objectives import RigChart
from stereorecal.scoring import Tracks

# Standard deviations of what windows say, in those that their tracks alone would leave: neighbours err together.
_WORSE = (1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0, 15.0)
_OF_OTHER_THINGS = 0.05  # probability that most of what moves is not the rig
_OTHER_WAYS = 0.05  # probability that the ways are of another vehicle, in other units, by another clock
_ANY_LENGTH = 4.6  # logarithm of the range in which those lie
_OWN_YAW = 1.0  # degrees: how far depth seems to be off, then


@dataclass(frozen=True, eq=False)
class Windows:
    """Tracks of some windows of one rig.

    Attributes:
        tracks: of each.
        frames: numbers of the two pairs of each, as correspondences have them; empty where they are not known.
        seconds: from one pair to the other; those of all windows are 1 where times are not known.
        ways: the distance travelled in each from an odometer, and its standard deviation, metres; None where that is
            not known, empty where no odometer was given.
    """

    tracks: tuple[Tracks, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    seconds: tuple[float, ...] = ()
    ways: tuple[tuple[float, float] | None, ...] = ()

    def numbered(self, used: Sequence[int]) -> "Windows":
        """The windows of the frames that are used, which are numbered anew.

        Args:
            used: numbers of these frames, in their new order.
        """
        new = {frame: number for number, frame in enumerate(used)}
        some = [number for number, frames in enumerate(self.frames) if all(frame in new for frame in frames)]
        return Windows(
            tuple(self.tracks[number] for number in some),
            tuple((new[self.frames[number][0]], new[self.frames[number][1]]) for number in some),
            tuple(self.seconds[number] for number in some),
            tuple(self.ways[number] for number in some if self.ways),
        )

    def linear_at(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> tuple[Window, ...]:
        """The window of each pair of pairs, linear near θ."""
        return tuple(window(one, chart, theta, way) for one, way in zip(self.tracks, self.all_ways, strict=True))

    @property
    def all_ways(self) -> tuple[tuple[float, float] | None, ...]:
        """One for each window."""
        return self.ways or (None,) * len(self.tracks)

    @property
    def measured(self) -> bool:
        """Whether an odometer measured the distance travelled in any of them."""
        return any(way is not None for way in self.ways)

    def __bool__(self) -> bool:
        return any(len(one) for one in self.tracks)

    def likelihoods(
        self, chart: RigChart, theta: Float[np.ndarray, "n"], prior: CalibrationPrior
    ) -> list[tuple[float, Normal]]:
        """What the windows may tell of θ, near a θ, as `MatchedRanges.likelihoods`: all of it, or all but depth."""
        if not self:
            return [(0.0, Normal(np.zeros((chart.dim,) * 2), np.zeros(chart.dim), 0.0))]
        within = root_and_mean(prior)
        windows = self.linear_at(chart, theta)
        return self.explained(together([one.normal for one in windows], *within), of_ways(windows), chart)

    def explained(self, alone: Normal, by_ways: Normal, chart: RigChart) -> list[tuple[float, Normal]]:
        """What they may tell together, each with the logarithm of its probability: with the ways, if those are of this
        rig; without; and nothing of depth.

        Args:
            alone: without ways.
            by_ways: what these add.
            chart: of the rig; ways of less than a tenth of its baseline do not count.
        """
        explanations = [
            (float(np.log1p(-_OF_OTHER_THINGS)), alone),
            (float(np.log(_OF_OTHER_THINGS)), without_depth(alone)),
        ]
        ways = [way for way in self.ways if way is not None and far_enough(way[0], chart.rig)]
        if not ways:
            return explanations
        # Ways of anything else have any length: against that, their density counts, once, as all err alike.
        sigma = float(np.median([way[1] / way[0] for way in ways])) / np.sqrt(len(ways))
        narrower = float(np.log(_ANY_LENGTH / (sigma * np.sqrt(2.0 * np.pi))))
        own = float(np.log1p(-_OF_OTHER_THINGS) + np.log1p(-_OTHER_WAYS)) + narrower
        return [(own, alone + by_ways), *((float(log + np.log(_OTHER_WAYS)), normal) for log, normal in explanations)]


def of_ways(windows: Sequence[Window]) -> Normal:
    """What ways add to windows: they err by themselves, however wrong the tracks are."""
    return reduce(add, (one.with_distance - one.normal for one in windows))


NO_WINDOWS = Windows()


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
        found.append((marginal(scaled.around(mean), root).c, scaled))
    return min(found, key=lambda one: one[0])[1]


def without_depth(normal: Normal) -> Normal:
    """The likelihood if the depth in all windows is not that of the rig: with a yaw of its own."""
    n = len(normal.b)
    axis = np.eye(n)[DRIFTING.index("yaw")]
    to = np.column_stack([np.eye(n), axis])
    return marginal(Normal(to.T @ normal.a @ to, to.T @ normal.b, normal.c), np.array([[_OWN_YAW]]))
