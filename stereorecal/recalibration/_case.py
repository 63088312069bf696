"""The case of a repair: what is repaired, with what, and what is known of it; which frames of a long recording are
looked at, and which of them follow each other."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, starmap

from stereorecal.estimation import EXACT, Prior
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Parameters, RigChart, row_chart
from stereorecal.recalibration._prior_use import PriorUse
from stereorecal.recalibration._schedule import Stage
from stereorecal.recalibration._settings import Settings
from stereorecal.recordings import Pair, Range, times_of
from stereorecal.scoring import Pyramid, select_frames

MOST_FRAMES = 24  # of a recording: more of one place tell hardly more, and each costs a match
_LEAST = 0.09  # seconds from one pair to the next: in less, hardly anything moves; 10 Hz, with what clocks err
_SOON = 0.5  # seconds, at most: farther apart, few corners can be followed


def chosen_frames(pairs: Sequence[Pair], most: int = MOST_FRAMES) -> tuple[Pair, ...]:
    """The pairs to look at, at most so many, in order: of equal stretches, which are moments apart, the ones with the
    most texture; where pairs were taken soon after each other, of half as many, each with one a moment later: the rig's
    own motion tells depth."""
    windows = most > 1 and any(starmap(soon_after, pairwise(times_of(pairs))))
    return select_frames(pairs, most, a_moment_after if windows else None)


def soon_after(first: float | None, second: float | None) -> bool:
    """Whether the times of two pairs say that one was taken soon after the other."""
    return first is not None and second is not None and 0.0 < second - first <= _SOON


def a_moment_after(first: Pair, second: Pair) -> bool:
    """The same, and not so soon that nothing has moved: of 30 pairs a second, the third after."""
    return soon_after(first.time, second.time) and (second.time or 0.0) - (first.time or 0.0) >= _LEAST


@dataclass(frozen=True, eq=False)
class Case:
    """What is repaired, and with what.

    Attributes:
        images: taken by the rig whose extrinsics, the initial ones, are the centre of the search box and of the prior.
        settings: that were asked for; their `free` is what may change in the end.
        matcher: with its disparity range at full size; before a search it may lack that.
        free: what the search may change: extrinsics, and in comparisons all else that strategies search.
        prior: of what the initial calibration leaves; EXACT: its intrinsics are the truth.
        ranges: of what the images show.
        windows: numbers of pairs that follow each other.
        prior_use: where the prior came from, and which of the pairs that were given count; None: no user gave one.
        selected: numbers of the pairs of `images` among those that were given; None: all of them.
    """

    images: Pyramid
    settings: Settings
    matcher: AbstractMatcher
    free: Parameters
    prior: Prior = EXACT
    ranges: tuple[Range, ...] = ()
    windows: tuple[tuple[int, int], ...] = ()
    prior_use: PriorUse | None = None
    selected: tuple[int, ...] | None = None

    @property
    def rig(self) -> StereoRig:
        """The initial calibration."""
        return self.images.rig

    @property
    def anew(self) -> "Case":
        """The same, of which nothing is prepared yet: of many recordings that would fill the memory."""
        return replace(self, images=Pyramid(self.rig, self.images.pairs, self.images.view))

    @property
    def chart(self) -> RigChart:
        """The box of epipolar residuals, with the prior."""
        return row_chart(self.rig, self.settings.reach, self.free)

    def scale_of(self, stage: Stage) -> float:
        """The image scale at which a stage works."""
        return stage.scale_for(self.rig.left.size)
