"""The case of a repair: what is repaired, with what, and what is known of it."""

from dataclasses import dataclass, replace

from stereorecal.decision import DEFAULT, Tolerances
from stereorecal.estimation import EXACT, Prior
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Parameters, Reach, RigChart, row_chart
from stereorecal.recalibration._prior_use import PriorUse
from stereorecal.recalibration._schedule import Stage
from stereorecal.recordings import Odometer, Range
from stereorecal.scoring import Pyramid


@dataclass(frozen=True, eq=False)
class Case:
    """What is repaired, and with what.

    Attributes:
        images: taken by the rig whose extrinsics, the initial ones, are the centre of the search box and of the prior.
        matcher: with its disparity range at full size.
        free: what the step at hand may change; the rest is held. In the search extrinsics, and for comparisons all else
            that strategies may search; in the decision all that may change in the end (`with_free`).
        prior: of what the initial calibration leaves; EXACT: its intrinsics are the truth.
        ranges: of what the images show.
        windows: numbers of pairs that follow each other.
        tolerances: by which it is decided.
        odometer: what else knows how far the rig travelled.
        prior_use: where the prior came from, and which of the pairs that were given count; None: no user gave one.
        selected: numbers of the pairs of `images` among those that were given; None: all of them.
    """

    images: Pyramid
    matcher: AbstractMatcher
    reach: Reach
    free: Parameters
    prior: Prior = EXACT
    ranges: tuple[Range, ...] = ()
    windows: tuple[tuple[int, int], ...] = ()
    tolerances: Tolerances = DEFAULT
    odometer: Odometer | None = None
    prior_use: PriorUse | None = None
    selected: tuple[int, ...] | None = None

    @property
    def rig(self) -> StereoRig:
        """The initial calibration."""
        return self.images.rig

    @property
    def chart(self) -> RigChart:
        """The box of epipolar residuals, with the prior."""
        return row_chart(self.rig, self.reach, self.free)

    @property
    def of_extrinsics(self) -> "Case":
        """The same case with nothing but the extrinsics free."""
        return self.with_free(self.free.extrinsics)

    @property
    def without_intrinsics(self) -> "Case":
        """The same case with the intrinsics held."""
        return self.with_free(Parameters(tuple(name for name in self.free.names if "." not in name), self.free.priors))

    def with_free(self, free: Parameters) -> "Case":
        """The same case with other parameters free."""
        return replace(self, free=free)

    def scale_of(self, stage: Stage) -> float:
        """The image scale at which a stage works."""
        return stage.scale_for(self.rig.left.size)

    def with_matcher(self, matcher: AbstractMatcher) -> "Case":
        """The same case with another matcher."""
        return replace(self, matcher=matcher)
